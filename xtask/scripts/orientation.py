#!/usr/bin/env python3
"""What a judge of quad meshes alone cannot see. Needs numpy and scipy.

    orientation.py OUT.obj IN.obj

Prints JSON:
  facing_against   quads whose normal (cross of the diagonals) points against every nearby sample of the input
  boundary_mean, boundary_max
                   distance between the boundary curves, both ways, % of the input's bounding-box diagonal

Independent of the command: reads the two files and nothing else. Sampled; deterministic.
"""
import json
import sys
from collections import Counter

import numpy as np
from scipy.spatial import cKDTree

SURFACE_SAMPLES = 400_000
NEIGHBOURS = 12
# Boundary curves are sampled at this part of the diagonal, which is the error of the figures.
BOUNDARY_SPACING = 5e-5


def load(path):
    points, faces = [], []
    with open(path, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            word = line.split()
            if word[:1] == ["v"]:
                points.append([float(x) for x in word[1:4]])
            elif word[:1] == ["f"]:
                corner = [int(x.split("/")[0]) for x in word[1:]]
                faces.append([c - 1 if c > 0 else len(points) + c for c in corner])
    return np.array(points, float).reshape(-1, 3), faces


def surface_samples(points, faces):
    tris = np.array([(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)], int)
    a, b, c = (points[tris[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(area, 1e-300)[:, None]
    rng = np.random.default_rng(1)
    pick = rng.choice(len(tris), SURFACE_SAMPLES, p=area / area.sum())
    s, t = np.sqrt(rng.random(len(pick)))[:, None], rng.random(len(pick))[:, None]
    random = a[pick] * (1 - s) + b[pick] * (s * (1 - t)) + c[pick] * (s * t)
    return np.vstack([random, (a + b + c) / 3]), np.vstack([normal[pick], normal])


def facing_against(points, faces, ref_points, ref_faces):
    quads = np.array([f for f in faces if len(f) == 4], int)
    if not len(quads):
        return 0
    corner = points[quads]
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    where, theirs = surface_samples(ref_points, ref_faces)
    _, near = cKDTree(where).query(corner.mean(axis=1), k=NEIGHBOURS)
    return int(((theirs[near] * normal[:, None, :]).sum(-1).max(axis=1) < 0).sum())


def boundary(faces):
    use = Counter(tuple(sorted(side)) for f in faces for side in zip(f, f[1:] + f[:1]))
    return [e for e, n in use.items() if n == 1]


def along(points, edges, spacing):
    samples = []
    for a, b in edges:
        n = max(2, int(np.linalg.norm(points[a] - points[b]) / spacing) + 1)
        t = np.linspace(0, 1, n)[:, None]
        samples.append(points[a] * (1 - t) + points[b] * t)
    return np.vstack(samples)


def main():
    points, faces = load(sys.argv[1])
    ref_points, ref_faces = load(sys.argv[2])
    used = ref_points[np.unique(np.concatenate([np.array(f) for f in ref_faces]))]
    diagonal = np.linalg.norm(np.ptp(used, axis=0))
    say = {"facing_against": facing_against(points, faces, ref_points, ref_faces)}
    ours, theirs = boundary(faces), boundary(ref_faces)
    if ours and theirs:
        here = along(points, ours, BOUNDARY_SPACING * diagonal)
        there = along(ref_points, theirs, BOUNDARY_SPACING * diagonal)
        d1, d2 = cKDTree(there).query(here)[0], cKDTree(here).query(there)[0]
        say["boundary_mean"] = float((d1.mean() + d2.mean()) / 2 / diagonal * 100)
        say["boundary_max"] = float(max(d1.max(), d2.max()) / diagonal * 100)
    print(json.dumps(say))


if __name__ == "__main__":
    main()
