#!/usr/bin/env python3
"""What a judge of quad meshes alone cannot see. Needs numpy and scipy.

    orientation.py OUT.obj IN.obj

Prints JSON:
  facing_against   quads whose normal (cross of the diagonals) points against every triangle of the input that is
                   nearest to their centre; on a ridge several are
  boundary_mean, boundary_max
                   distance between the boundary curves, both ways, % of the input's bounding-box diagonal

Independent of the command: reads the two files and nothing else. Triangles to be compared are found by samples, their
distances are exact; boundaries are sampled; deterministic.
"""
import json
import sys
from collections import Counter

import numpy as np
from scipy.spatial import cKDTree

SURFACE_SAMPLES = 400_000
NEIGHBOURS = 96
# Sides of triangles are sampled at this part of the diagonal: slivers have hardly any area.
SIDE_SPACING = 1e-3
# Triangles that are farther than the nearest one by less than this part of the diagonal are as near: rounding.
AS_NEAR = 1e-9
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


def triangles(points, faces):
    return points[np.array([(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)], int)]


def surface_samples(corner):
    """Points on the triangles, and the triangle of each."""
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    rng = np.random.default_rng(1)
    pick = rng.choice(len(corner), SURFACE_SAMPLES, p=area / area.sum())
    s, t = np.sqrt(rng.random(len(pick)))[:, None], rng.random(len(pick))[:, None]
    random = a[pick] * (1 - s) + b[pick] * (s * (1 - t)) + c[pick] * (s * t)
    where, owner = [random, (a + b + c) / 3], [pick, np.arange(len(corner))]
    spacing = SIDE_SPACING * np.linalg.norm(np.ptp(corner.reshape(-1, 3), axis=0))
    for u, v in ((a, b), (b, c), (c, a)):
        count = 1 + (np.linalg.norm(v - u, axis=1) / spacing).astype(int)
        of = np.repeat(np.arange(len(corner)), count)
        at = (np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[of]
        where.append(u[of] + (v - u)[of] * at[:, None])
        owner.append(of)
    return np.vstack(where), np.concatenate(owner)


def to_segment(p, a, b):
    along = b - a
    t = ((p - a) * along).sum(-1) / np.maximum((along * along).sum(-1), 1e-300)
    return np.linalg.norm(a + along * np.clip(t, 0, 1)[..., None] - p, axis=-1)


def to_triangle(p, a, b, c):
    """Exact distances of points from triangles."""
    normal = np.cross(b - a, c - a)
    inside = np.ones(a.shape[:-1], bool)
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= (np.cross(v - u, p - u) * normal).sum(-1) >= 0
    length = np.linalg.norm(normal, axis=-1)
    height = np.abs(((p - a) * normal).sum(-1)) / np.maximum(length, 1e-300)
    rim = np.minimum(np.minimum(to_segment(p, a, b), to_segment(p, b, c)), to_segment(p, c, a))
    return np.where(inside & (length > 0), height, rim)


def facing_against(points, faces, ref_points, ref_faces):
    quads = np.array([f for f in faces if len(f) == 4], int)
    if not len(quads):
        return 0
    corner = points[quads]
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    theirs = triangles(ref_points, ref_faces)
    where, owner = surface_samples(theirs)
    centre = corner.mean(axis=1)
    _, near = cKDTree(where).query(centre, k=NEIGHBOURS)
    a, b, c = (theirs[owner[near]][:, :, k] for k in range(3))
    distance = to_triangle(centre[:, None, :], a, b, c)
    least = distance.min(axis=1, keepdims=True)
    is_nearest = distance <= least + AS_NEAR * np.linalg.norm(np.ptp(ref_points, axis=0))
    along = (np.cross(b - a, c - a) * normal[:, None, :]).sum(-1)
    return int((np.where(is_nearest, along, -np.inf).max(axis=1) < 0).sum())


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
