"""Judges a regular map drawn on a surface by the mesh alone; shares no code with the program that wrote it.

    python3 drawn_map.py FILE.obj [--faces F] [--edges E] [--vertices V] [--genus G] [--type P,Q] [--petrie R]

The OBJ has a group `face_K` for every face of the map, as `quadloom regular-map realize --edges none` writes it. The
triangles must be a closed oriented manifold, those of a group one disk. Edges of the mesh between two groups are chained:
where more than two of them meet is a vertex of the map, a chain from one vertex to the next is an edge. Faces, edges and
vertices give the flags of the map; it is regular if its first flag can be taken to each of its three neighbours by an
automorphism. An edge with the same face on both sides cannot be seen, so a map with one face is only judged as a surface.
Prints one JSON object; `defects` is empty, and the exit code 0, where all holds and all numbers are those given.
"""
import argparse
import json
import sys


def read(path):
    count, faces, group, names, current = 0, [], [], {}, None
    for line in open(path):
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            count += 1
        elif words[0] in ("g", "o"):
            current = " ".join(words[1:])
        elif words[0] == "f":
            corners = [int(w.split("/")[0]) - 1 for w in words[1:]]
            for k in range(1, len(corners) - 1):
                faces.append((corners[0], corners[k], corners[k + 1]))
                group.append(names.setdefault(current, len(names)))
    return count, faces, group, list(names)


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


class Surface:
    """Triangles with neighbours: `twin` of half-edge 3f + k, which runs from corner k of face f to the next."""

    def __init__(self, faces, defects):
        self.faces = faces
        self.tail = [v for f in faces for v in f]
        self.head = [v for f in faces for v in (f[1], f[2], f[0])]
        at = {}
        for h, side in enumerate(zip(self.tail, self.head)):
            if side in at:
                defects.append(f"faces {at[side] // 3} and {h // 3} run along an edge in the same direction")
            at[side] = h
        self.twin = [at.get((b, a)) for a, b in zip(self.tail, self.head)]
        if None in self.twin:
            defects.append(f"{self.twin.count(None)} edges have one face only")
        self.edges = len({frozenset(side) for side in at})
        self.vertices = len(set(self.tail))

    def next(self, h):
        return h - 2 if h % 3 == 2 else h + 1

    def previous(self, h):
        return h + 2 if h % 3 == 0 else h - 1

    def chi(self):
        return self.vertices - self.edges + len(self.faces)

    def pieces(self, are_joined):
        """Faces and corners as sets, joined across the edges for which `are_joined` says so."""
        pieces, corners = Sets(len(self.faces)), Sets(len(self.tail))
        for h, t in enumerate(self.twin):
            if t is not None and are_joined(h, t):
                pieces.join(h // 3, t // 3)
                corners.join(h, self.next(t))
                corners.join(self.next(h), t)
        return pieces, corners


def check_surface(surface, defects):
    pieces, corners = surface.pieces(lambda h, t: True)
    shells = len({pieces.root(f) for f in range(len(surface.faces))})
    if shells != 1:
        defects.append(f"{shells} pieces instead of one")
    if len({corners.root(c) for c in range(len(surface.tail))}) != surface.vertices:
        defects.append("a vertex joins several fans of faces")


def check_disks(surface, group, names, defects):
    of = lambda h: group[h // 3]
    pieces, corners = surface.pieces(lambda h, t: of(h) == of(t))
    mine = [{"pieces": set(), "corners": set(), "sides": 0, "inner": 0, "faces": 0, "border": {}} for _ in names]
    for f, k in enumerate(group):
        mine[k]["pieces"].add(pieces.root(f))
        mine[k]["faces"] += 1
    for h, t in enumerate(surface.twin):
        data = mine[of(h)]
        data["corners"].add(corners.root(h))
        if t is not None and of(t) == of(h):
            data["inner"] += 1
        else:
            data["sides"] += 1
            # On the group cut open a corner class has one side that leaves it along the border.
            data["border"][corners.root(h)] = corners.root(surface.next(h))
    for name, data in zip(names, mine):
        chi = len(data["corners"]) - data["sides"] - data["inner"] // 2 + data["faces"]
        loops, left = 0, set(data["border"])
        while left:
            loops += 1
            at = left.pop()
            while (at := data["border"].get(at)) in left:
                left.discard(at)
        if len(data["pieces"]) != 1 or chi != 1 or loops != 1 or len(data["border"]) != data["sides"]:
            defects.append(f"{name} is no disk: {len(data['pieces'])} pieces, chi {chi}, {loops} borders")


def chains(surface, group, defects):
    """Sides of the map: half-edge chains along the border of a group from one vertex of the map to the next."""
    border = [t is not None and group[h // 3] != group[t // 3] for h, t in enumerate(surface.twin)]
    degree = {}
    for h, here in enumerate(border):
        if here:
            degree[surface.tail[h]] = degree.get(surface.tail[h], 0) + 1
    crossing = {v for v, n in degree.items() if n != 2}
    onward = {}
    for h, here in enumerate(border):
        if here:
            # Turn inside the group around the head until the border goes on.
            at = surface.next(h)
            while not border[at]:
                at = surface.next(surface.twin[at])
            onward[h] = at
    side_of, sides = {}, []
    for first in onward:
        if surface.tail[first] not in crossing:
            continue
        chain = [first]
        while surface.head[chain[-1]] not in crossing:
            chain.append(onward[chain[-1]])
        for h in chain:
            side_of[h] = len(sides)
        sides.append(chain)
    if len(side_of) != len(onward):
        defects.append(f"{len(onward) - len(side_of)} half-edges of borders lie on rings without a vertex of the map")
        return None
    mate = []
    for number, chain in enumerate(sides):
        others = {side_of[surface.twin[h]] for h in chain}
        if len(others) != 1 or len({group[surface.twin[h] // 3] for h in chain}) != 1:
            defects.append(f"side {number} runs along several others")
            return None
        mate.append(others.pop())
    following = [side_of[onward[chain[-1]]] for chain in sides]
    return {"crossing": {v: degree[v] for v in crossing}, "sides": sides, "mate": mate, "next": following}


def flags(found):
    """Reflections of the flags (side, end): end 0 is the tail of the side, 1 its head."""
    count = len(found["sides"])
    before = [0] * count
    for s, n in enumerate(found["next"]):
        before[n] = s
    number = lambda side, end: 2 * side + end
    r0 = [number(f // 2, 1 - f % 2) for f in range(2 * count)]
    r1 = [number(found["next"][f // 2], 0) if f % 2 else number(before[f // 2], 1) for f in range(2 * count)]
    r2 = [number(found["mate"][f // 2], 1 - f % 2) for f in range(2 * count)]
    return r0, r1, r2


def takes(reflections, start, image):
    """Whether an automorphism takes one flag to another."""
    to, reached, queue = {start: image}, {image}, [start]
    for f in queue:
        for r in reflections:
            a, b = r[f], r[to[f]]
            if a not in to:
                if b in reached:
                    return False
                to[a] = b
                reached.add(b)
                queue.append(a)
            elif to[a] != b:
                return False
    return len(to) == len(reflections[0])


def orbit(flag, steps):
    at, length = flag, 0
    while True:
        for r in steps:
            at = r[at]
        length += 1
        if at == flag:
            return length


def judge(path, wanted):
    defects = []
    count, faces, group, names = read(path)
    stray = [name for name in names if not (name or "").startswith("face_")]
    if stray:
        defects.append(f"groups that are no faces: {stray[:3]}; the map must be drawn without edges")
    surface = Surface(faces, defects)
    if surface.vertices != count:
        defects.append(f"{count - surface.vertices} vertices belong to no face")
    result = {"triangles": len(faces), "chi": surface.chi(), "genus": (2 - surface.chi()) // 2, "faces": len(names)}
    if not defects:
        check_surface(surface, defects)
    if len(names) == 1:
        result["note"] = "one face: its edges cannot be seen"
    elif not defects:
        check_disks(surface, group, names, defects)
        found = chains(surface, group, defects) if not defects else None
        if found:
            reflections = flags(found)
            sides, vertices = len(found["sides"]), len(found["crossing"])
            result |= {"edges": sides // 2, "vertices": vertices, "chi_of_map": vertices - sides // 2 + len(names)}
            every = range(2 * sides)
            result["p"] = sorted({orbit(f, reflections[:2]) for f in every})
            result["q"] = sorted(set(found["crossing"].values()) | {orbit(f, reflections[1:]) for f in every})
            result["petrie"] = sorted({orbit(f, reflections) for f in every})
            result["regular"] = all(takes(reflections, 0, r[0]) for r in reflections)
            if result["chi_of_map"] != result["chi"]:
                defects.append(f"the map has chi {result['chi_of_map']}, the surface {result['chi']}")
            if not result["regular"]:
                defects.append("the drawn map is not regular")
    for key, value in wanted.items():
        seen = result.get(key)
        if value is not None and seen is not None and seen not in (value, [value]):
            defects.append(f"{key}: {seen}, not {value}")
    return result | {"defects": defects[:20]}


def main():
    parser = argparse.ArgumentParser(description="judges a drawn regular map")
    parser.add_argument("file")
    for name in ("faces", "edges", "vertices", "genus", "petrie"):
        parser.add_argument(f"--{name}", type=int)
    parser.add_argument("--type", help="P,Q")
    options = vars(parser.parse_args())
    path, kind = options.pop("file"), options.pop("type")
    options["p"], options["q"] = map(int, kind.split(",")) if kind else (None, None)
    result = judge(path, options)
    print(json.dumps(result))
    sys.exit(1 if result["defects"] else 0)


main()
