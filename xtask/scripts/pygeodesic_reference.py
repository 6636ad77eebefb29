"""Distances of all vertices from one by PyPI's pygeodesic (exact, point sources), and the seconds of its call.

    python3 pygeodesic_reference.py MODEL.obj VERTEX OUT.txt

Prints JSON: {"seconds": s}, or {"error": why}. OUT gets one number a line, in the order of the file. Only the call is
timed; reading and preparing the mesh are not.
"""

import json
import sys
import time


def read(path):
    points, faces = [], []
    for line in open(path):
        if line.startswith("v "):
            points.append([float(x) for x in line.split()[1:4]])
        elif line.startswith("f "):
            faces.append([int(x.split("/")[0]) - 1 for x in line.split()[1:4]])
    return points, faces


def main():
    try:
        import numpy
        import pygeodesic.geodesic as geodesic
    except ImportError as error:
        print(json.dumps({"error": str(error)}))
        return
    points, faces = read(sys.argv[1])
    algorithm = geodesic.PyGeodesicAlgorithmExact(numpy.array(points), numpy.array(faces))
    begin = time.perf_counter()
    distances, _ = algorithm.geodesicDistances(numpy.array([int(sys.argv[2])]), None)
    seconds = time.perf_counter() - begin
    with open(sys.argv[3], "w") as out:
        out.writelines(f"{d!r}\n" for d in distances.tolist())
    print(json.dumps({"seconds": seconds}))


main()
