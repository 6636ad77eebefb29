"""Judges files as printable solids with libraries that are not ours.

    python3 solid.py FILE... [--genus G] [--shells N] [--without-intersections]

STL, OBJ or PLY. Vertices of an STL are merged where all three coordinates are equal, nowhere else. Closed, wound one way
and outwards by `trimesh`; free of self-intersection by `open3d`, whose test looks at all pairs of triangles that share no
vertex and is left out with `--without-intersections`, for files too large for that; chi, genus, shells and vertices that
join several fans by counting here. Prints a JSON list, one object for each file; the exit code is 0 only where all holds
for all of them.
"""
import argparse
import json
import sys
import time

import numpy as np
import trimesh


def read(path):
    kind = path.rsplit(".", 1)[-1].lower()
    if kind == "obj":
        points, faces = [], []
        for line in open(path):
            words = line.split()
            if words[:1] == ["v"]:
                points.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
                faces += [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
        return np.array(points, dtype=np.float64), np.array(faces, dtype=np.int64)
    mesh = trimesh.load(path, process=False, force="mesh")
    points, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    if kind == "stl":
        points, number = np.unique(points, axis=0, return_inverse=True)
        faces = number.reshape(-1)[faces]
    return points, faces


def sets(n, pairs):
    """Number of classes of 0..n joined by pairs."""
    label = np.arange(n)
    a, b = pairs.T
    while True:
        low = np.minimum(label[a], label[b])
        before = label.copy()
        np.minimum.at(label, label[a], low)
        np.minimum.at(label, label[b], low)
        label = label[label]
        if np.array_equal(label, before):
            return len(np.unique(label))


def judge(path, options):
    points, faces = read(path)
    defects = []
    used = len(np.unique(faces))
    if used != len(points):
        defects.append(f"{len(points) - used} vertices belong to no face")
    degenerate = np.count_nonzero((faces == np.roll(faces, 1, axis=1)).any(axis=1))
    if degenerate:
        defects.append(f"{degenerate} faces have two corners in one place")
    # Half-edge 3f + k runs from corner k of face f to the next.
    tail, head = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    edges, at, sides = np.unique(np.stack([low, high], axis=1), axis=0, return_inverse=True, return_counts=True)
    closed = bool((sides == 2).all())
    turned = bool((np.bincount(at.reshape(-1), np.where(tail < head, 1, -1)) == 0).all())
    if not closed:
        defects.append(f"{np.count_nonzero(sides != 2)} edges have not two faces")
    elif not turned:
        defects.append("faces along an edge run in the same direction")
    chi = used - len(edges) + len(faces)
    result = {"file": path.rsplit("/", 1)[-1], "vertices": used, "edges": len(edges), "faces": len(faces), "chi": chi}
    if closed and turned:
        order = np.lexsort((tail > head, at.reshape(-1)))
        h, t = order[0::2], order[1::2]
        onward = lambda x: x - x % 3 + (x + 1) % 3
        result["shells"] = sets(len(faces), np.stack([h // 3, t // 3], axis=1))
        corners = np.concatenate([np.stack([h, onward(t)], axis=1), np.stack([onward(h), t], axis=1)])
        if sets(len(tail), corners) != used:
            defects.append("a vertex joins several fans of faces")
        result["genus"] = (2 * result["shells"] - chi) // 2
        if options.genus is not None and result["genus"] != options.genus:
            defects.append(f"genus {result['genus']}, not {options.genus}")
        if result["shells"] != options.shells:
            defects.append(f"{result['shells']} shells, not {options.shells}")
    solid = trimesh.Trimesh(points, faces, process=False)
    result["watertight"] = bool(solid.is_watertight)
    result["winding_consistent"] = bool(solid.is_winding_consistent)
    result["volume"] = float(solid.volume)
    result["size"] = [float(x) for x in solid.extents]
    if not (result["watertight"] and result["winding_consistent"] and result["volume"] > 0):
        defects.append("no solid by trimesh")
    if not options.without_intersections:
        import open3d
        begin = time.perf_counter()
        seen = open3d.geometry.TriangleMesh(
            open3d.utility.Vector3dVector(points), open3d.utility.Vector3iVector(faces.astype(np.int32)))
        result["self_intersecting"] = bool(seen.is_self_intersecting())
        result["seconds_of_open3d"] = round(time.perf_counter() - begin, 3)
        if result["self_intersecting"]:
            defects.append("intersects itself by open3d")
    return result | {"defects": defects}


def main():
    parser = argparse.ArgumentParser(description="judges files as printable solids")
    parser.add_argument("files", nargs="+")
    parser.add_argument("--genus", type=int)
    parser.add_argument("--shells", type=int, default=1)
    parser.add_argument("--without-intersections", action="store_true", help="leave the test of open3d out")
    options = parser.parse_args()
    results = [judge(path, options) for path in options.files]
    print(json.dumps(results))
    sys.exit(1 if any(r["defects"] for r in results) else 0)


main()
