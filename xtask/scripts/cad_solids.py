#!/usr/bin/env python3
"""Random solids to evaluate with. Needs numpy, manifold3d and scikit-image (all from PyPI).

    cad_solids.py FOLDER FANDISK.obj

Writes OBJ files to FOLDER and prints their names as JSON:
  boolean_00 .. 19       unions and differences of boxes, cylinders, wedges and spheres: sharp edges, bores, long needles
  blend_00 .. 19         smooth unions of balls, tubes and rings, by marching cubes
  fandisk_degenerate     fandisk with 1,000 triangles of zero area, closed
  fandisk_noise          fandisk with noise of 0.3 % of its diagonal

Seeded: the same files every time. Pieces of less than a twentieth of the volume are dropped.
"""
import json
import sys
from pathlib import Path

import numpy as np
from manifold3d import Manifold, Mesh
from skimage.measure import marching_cubes

SOLIDS = 20


def write(path, points, triangles):
    with open(path, "w") as out:
        out.writelines("v %r %r %r\n" % tuple(float(x) for x in p) for p in points)
        out.writelines("f %d %d %d\n" % tuple(int(i) + 1 for i in t) for t in triangles)


def largest(solid):
    """Without crumbs, as vertices and triangles."""
    pieces = solid.decompose()
    whole = sum(abs(p.volume()) for p in pieces)
    kept = Manifold.compose([p for p in pieces if abs(p.volume()) > 0.05 * whole])
    mesh = kept.to_mesh64()
    points, triangles = np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts, int)
    # Vertices that differ only in their properties are one vertex.
    merge = np.arange(len(points))
    merge[np.array(mesh.merge_from_vert, int)] = np.array(mesh.merge_to_vert, int)
    triangles = merge[triangles]
    used, index = np.unique(triangles, return_inverse=True)
    return points[used], index.reshape(-1, 3)


def primitive(rng):
    size = rng.uniform(0.4, 1.2, 3)
    kind = rng.integers(5)
    if kind <= 1:
        solid = Manifold.cube(size, center=True)
    elif kind == 2:
        solid = Manifold.cylinder(size[2], size[0] / 2, size[0] / 2, int(rng.choice([24, 36, 48])), center=True)
    elif kind == 3:
        solid = Manifold.cylinder(size[2], size[0] / 2, size[0] / 4, int(rng.choice([24, 36])), center=True)
    else:
        solid = Manifold.sphere(size[0] / 2, 40)
    angles = rng.choice([0.0, 0.0, 0.0, 90.0, 90.0, 45.0, 30.0], 3)
    return solid.rotate(angles).translate(rng.uniform(-0.35, 0.35, 3))


def bore(rng):
    hole = Manifold.cylinder(4.0, rng.uniform(0.08, 0.2), -1.0, 32, center=True)
    axis = [(0, 0, 0), (90, 0, 0), (0, 90, 0)][rng.integers(3)]
    return hole.rotate(axis).translate(rng.uniform(-0.25, 0.25, 3))


def boolean(seed):
    rng = np.random.default_rng(seed)
    solid = Manifold.cube((1.2, 1.0, 0.8), center=True)
    for _ in range(rng.integers(2, 5)):
        other = primitive(rng)
        solid = solid + other if rng.random() < 0.55 else solid - other
    for _ in range(rng.integers(1, 3)):
        solid = solid - bore(rng)
    # Half of them as the tessellation comes, with its needles; half finely divided.
    if seed % 2:
        solid = solid.refine_to_length(0.06)
    return solid


def smooth_union(a, b, k):
    h = np.maximum(k - np.abs(a - b), 0.0) / k
    return np.minimum(a, b) - h * h * k / 4


def blend(seed):
    rng = np.random.default_rng(1000 + seed)
    balls = [(rng.uniform(-0.6, 0.6, 3), rng.uniform(0.18, 0.4)) for _ in range(rng.integers(2, 5))]
    ends = [(rng.uniform(-0.7, 0.7, 3), rng.uniform(-0.7, 0.7, 3), rng.uniform(0.1, 0.2)) for _ in range(rng.integers(1, 4))]
    rings = [(rng.uniform(-0.3, 0.3, 3), rng.uniform(0.35, 0.55), rng.uniform(0.1, 0.16)) for _ in range(rng.integers(0, 3))]
    ticks = np.linspace(-1.4, 1.4, 64)
    p = np.stack(np.meshgrid(ticks, ticks, ticks, indexing="ij"), -1)
    d = np.full(p.shape[:3], 9.0)
    for centre, radius in balls:
        d = smooth_union(d, np.linalg.norm(p - centre, axis=-1) - radius, 0.2)
    for a, b, radius in ends:
        t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)[..., None]
        d = smooth_union(d, np.linalg.norm(p - a - t * (b - a), axis=-1) - radius, 0.2)
    for centre, big, small in rings:
        q = p - centre
        d = smooth_union(d, np.hypot(np.hypot(q[..., 0], q[..., 1]) - big, q[..., 2]) - small, 0.2)
    points, triangles, _, _ = marching_cubes(d, 0.0, spacing=(ticks[1] - ticks[0],) * 3)
    return Manifold(Mesh(points.astype(np.float32), triangles.astype(np.uint32)[:, ::-1]))


def load(path):
    points, triangles = [], []
    for line in open(path):
        word = line.split()
        if word[:1] == ["v"]:
            points.append([float(x) for x in word[1:4]])
        elif word[:1] == ["f"]:
            triangles.append([int(x.split("/")[0]) - 1 for x in word[1:4]])
    return np.array(points), np.array(triangles)


def with_degenerate(points, triangles, count, rng):
    """A midpoint on one side of an edge only, closed by a triangle of zero area."""
    points, triangles = list(points), [tuple(t) for t in triangles]
    touched = set()
    for i in rng.permutation(len(triangles)):
        if len(touched) == count:
            break
        if i in touched:
            continue
        touched.add(i)
        a, b, c = triangles[i]
        m = len(points)
        points.append((np.array(points[a]) + points[b]) / 2)
        triangles[i] = (a, m, c)
        triangles += [(m, b, c), (a, b, m)]
    return points, triangles


def main():
    folder, fandisk = Path(sys.argv[1]), sys.argv[2]
    names = []
    for make in (boolean, blend):
        for seed in range(SOLIDS):
            name = f"{make.__name__}_{seed:02d}"
            write(folder / f"{name}.obj", *largest(make(seed)))
            names.append(name)
    points, triangles = load(fandisk)
    rng = np.random.default_rng(89)
    write(folder / "fandisk_degenerate.obj", *with_degenerate(points, triangles, 1000, rng))
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    write(folder / "fandisk_noise.obj", points + rng.normal(0, 0.003 * diagonal, points.shape), triangles)
    names += ["fandisk_degenerate", "fandisk_noise"]
    print(json.dumps({"solids": names}))


if __name__ == "__main__":
    main()
