"""Judges tiles that `quadloom tile` wrote; shares no code with it.

    python3 reglue.py TILES.obj LAYOUT.json [SURFACE.obj]

Reads the groups, lines and texture coordinates of the mesh and the nodes, arcs and tiles of the layout. Every tile is cut
open along the lines and must be one piece with the Euler characteristic of its genus and boundaries; its border must be
the sides that the layout names, in order. Then equal sides are glued again: V, E and F must be those of the mesh.
Texture coordinates are tested for folds in exact arithmetic. Prints one JSON object; `defects` is empty if all holds.
"""
import json
import sys
from fractions import Fraction


class Sets:
    def __init__(self, n):
        self.up = list(range(n))

    def root(self, i):
        up = self.up
        while up[i] != i:
            up[i] = up[up[i]]
            i = up[i]
        return i

    def join(self, a, b):
        self.up[self.root(a)] = self.root(b)


def read_obj(path):
    points, places, faces, uv, group, lines, groups = [], [], [], [], [], [], {}
    current = None
    for text in open(path):
        words = text.split()
        if not words:
            continue
        if words[0] == "v":
            points.append(tuple(map(float, words[1:4])))
        elif words[0] == "vt":
            places.append(tuple(map(float, words[1:3])))
        elif words[0] == "g":
            current = groups.setdefault(words[1], len(groups))
        elif words[0] == "f":
            corners = [w.split("/") for w in words[1:]]
            faces.append(tuple(int(c[0]) - 1 for c in corners))
            group.append(current)
            if len(corners[0]) > 1:
                uv.append(tuple(places[int(c[1]) - 1] for c in corners))
        elif words[0] == "l":
            lines.append([int(w) - 1 for w in words[1:]])
    return points, faces, group, lines, uv


def euler(faces):
    vertices = {v for f in faces for v in f}
    edges = {frozenset((f[k], f[(k + 1) % 3])) for f in faces for k in range(3)}
    return len(vertices) - len(edges) + len(faces)


def is_folded(a, b, c):
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    # Far above rounding floating point decides; else fractions do.
    size = (abs(b[0] - a[0]) + abs(b[1] - a[1])) * (abs(c[0] - a[0]) + abs(c[1] - a[1]))
    if area > 1e-12 * size + 1e-300:
        return False
    (ax, ay), (bx, by), (cx, cy) = [tuple(map(Fraction, p)) for p in (a, b, c)]
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) <= 0


def judge(obj, layout, surface=None):
    points, faces, group, lines, uv = read_obj(obj)
    saved = json.load(open(layout))
    defects = []
    sides = {}
    for f, face in enumerate(faces):
        for k in range(3):
            if sides.setdefault((face[k], face[(k + 1) % 3]), (f, k)) != (f, k):
                defects.append(f"faces {f} and another run along an edge in the same direction")
    on_line, inner = {}, set()
    arcs = [a["vertices"] for a in saved["arcs"]]
    for number, path in enumerate(arcs):
        for a, b in zip(path, path[1:]):
            edge = frozenset((a, b))
            if edge in on_line:
                defects.append(f"arcs {number} and {on_line[edge]} share an edge")
            if (a, b) not in sides and (b, a) not in sides:
                defects.append(f"arc {number} leaves the edges of the mesh")
            on_line[edge] = number
        for v in path[1:-1]:
            if v in inner:
                defects.append(f"vertex {v} is inside two arcs")
            inner.add(v)
    nodes = {n["vertex"] for n in saved["nodes"]}
    if nodes & inner:
        defects.append("a node lies inside an arc")
    drawn = {frozenset(p) for line in lines for p in zip(line, line[1:])}
    cut = {e for e, n in on_line.items() if not saved["arcs"][n]["border"]}
    if drawn != cut:
        defects.append("the lines of the mesh are not the cuts of the layout")
    # Every tile cut open.
    corners = Sets(3 * len(faces))
    pieces = Sets(len(faces))
    for (a, b), (f, k) in sides.items():
        if (b, a) in sides and frozenset((a, b)) not in on_line:
            g, m = sides[(b, a)]
            corners.join(3 * f + k, 3 * g + (m + 1) % 3)
            corners.join(3 * f + (k + 1) % 3, 3 * g + m)
            pieces.join(f, g)
        elif (b, a) not in sides and frozenset((a, b)) not in on_line:
            defects.append(f"edge {a}, {b} of the border lies on no arc")
    by_tile = {}
    for f in range(len(faces)):
        by_tile.setdefault(group[f], []).append(f)
    if len(by_tile) != len(saved["tiles"]):
        defects.append(f"{len(by_tile)} groups and {len(saved['tiles'])} tiles")
    counts = []
    for tile, said in enumerate(saved["tiles"]):
        mine = by_tile.get(tile, [])
        if len({pieces.root(f) for f in mine}) != 1:
            defects.append(f"tile {tile} is not one piece")
        found = euler([tuple(corners.root(3 * f + k) for k in range(3)) for f in mine])
        stated = 2 - 2 * said["genus"] - len(said["boundaries"])
        if found != stated:
            defects.append(f"tile {tile} has chi {found}, not {stated}")
        counts.append(sum(len(b) for b in said["boundaries"]))
        around = set()
        for boundary in said["boundaries"]:
            path = []
            for side in boundary:
                vertices = arcs[side["arc"]]
                path += list(zip(vertices, vertices[1:])) if not side["reversed"] else [
                    (b, a) for a, b in reversed(list(zip(vertices, vertices[1:])))]
            for (a, b), (c, _) in zip(path, path[1:] + path[:1]):
                if b != c:
                    defects.append(f"a boundary of tile {tile} is broken")
                if (a, b) not in sides or group[sides[(a, b)][0]] != tile:
                    defects.append(f"a side of tile {tile} does not run along its faces")
                around.add((a, b))
        border = {h for h in ((faces[f][k], faces[f][(k + 1) % 3]) for f in mine for k in range(3))
                  if frozenset(h) in on_line}
        if around != border:
            defects.append(f"the sides of tile {tile} are not its border")
    # Glued again.
    uses = {}
    for tile, said in enumerate(saved["tiles"]):
        for boundary in said["boundaries"]:
            for side in boundary:
                uses.setdefault(side["arc"], []).append(side["reversed"])
    for arc, path in enumerate(arcs):
        for a, b in zip(path, path[1:]):
            here = [h for h in ((a, b), (b, a)) if h in sides]
            if len(here) != len(uses.get(arc, [])):
                defects.append(f"arc {arc} has another number of sides than faces beside it")
            if len(here) == 2:
                (f, k), (g, m) = sides[here[0]], sides[here[1]]
                corners.join(3 * f + k, 3 * g + (m + 1) % 3)
                corners.join(3 * f + (k + 1) % 3, 3 * g + m)
    v = len({corners.root(c) for c in range(3 * len(faces))})
    e = len({frozenset(h) for h in sides})
    if v != len({x for f in faces for x in f}) or v != len(points):
        defects.append(f"glued again there are {v} vertices of {len(points)}")
    folded = sum(is_folded(*corner) for corner in uv)
    if folded:
        defects.append(f"{folded} faces are folded in the plane")
    result = {"vertices": v, "edges": e, "faces": len(faces), "chi": v - e + len(faces), "tiles": len(by_tile),
              "sides": counts, "nodes": len(nodes), "mapped": len(uv), "defects": defects[:20]}
    if surface:
        old = read_obj(surface)
        used = {x for f in old[1] for x in f}
        edges = {frozenset((f[k], f[(k + 1) % len(f)])) for f in old[1] for k in range(len(f))}
        result["chi_of_surface"] = len(used) - len(edges) + len(old[1])
        if result["chi"] != result["chi_of_surface"]:
            defects.append("the surface has another Euler characteristic")
            result["defects"] = defects[:20]
    return result


if __name__ == "__main__":
    print(json.dumps(judge(*sys.argv[1:4])))
