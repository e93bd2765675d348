# SPDX-License-Identifier: MIT
"""A GLB's skins and clips, as much of them as check_importers.py needs, in plain Python."""
import json
import math
import pathlib
import struct

SIZES = {5121: ("B", 1), 5123: ("H", 2), 5125: ("I", 4), 5126: ("f", 4)}
COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
IDENTITY = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))
REST = {"translation": (0, 0, 0), "rotation": (0, 0, 0, 1), "scale": (1, 1, 1)}


def product(a, b):
    return tuple(tuple(sum(a[r][k] * b[k][c] for k in range(3)) + (a[r][3] if c == 3 else 0) for c in range(4))
                 for r in range(3))


def transform(m, x):
    return tuple(sum(m[r][c] * x[c] for c in range(3)) + m[r][3] for r in range(3))


def composed(translation, rotation, scale):
    length = math.sqrt(sum(x * x for x in rotation)) or 1
    x, y, z, w = (v / length for v in rotation)
    turn = ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))
    return tuple(tuple(turn[r][c] * scale[c] for c in range(3)) + (translation[r],) for r in range(3))


def of_columns(m):
    """A matrix as glTF has it."""
    return tuple(tuple(m[4 * c + r] for c in range(4)) for r in range(3))


class Tracks(dict):
    """(node, path) to key times and values of one clip."""

    def key_times(self, most):
        times = sorted({time for keys, _ in self.values() for time in keys})
        return times[::max(1, -(-len(times) // most))]

    def at(self, node, path, time):
        keys, values = self[node, path]
        after = next((k for k, t in enumerate(keys) if t >= time), len(keys) - 1)
        if after == 0 or time >= keys[after]:
            return values[after]
        share = (time - keys[after - 1]) / (keys[after] - keys[after - 1])
        a, b = values[after - 1], values[after]
        if len(a) == 4 and sum(p * q for p, q in zip(a, b)) < 0:
            b = tuple(-x for x in b)  # the short way; between keys so near a chord is an arc
        return tuple(p + share * (q - p) for p, q in zip(a, b))


class Glb:
    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json, self.binary = json.loads(data[20:20 + size]), data[28 + size:]
        self.nodes = self.json["nodes"]
        self.parent = [-1] * len(self.nodes)
        for n, node in enumerate(self.nodes):
            for child in node.get("children", []):
                self.parent[child] = n

    def rows(self, accessor):
        accessor = self.json["accessors"][accessor]
        width = COUNTS[accessor["type"]]
        view = self.json["bufferViews"][accessor["bufferView"]]
        code, size = SIZES[accessor["componentType"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", size * width)
        layout = struct.Struct(f"<{width}{code}")
        rows = [layout.unpack_from(self.binary, begin + i * stride) for i in range(accessor["count"])]
        if not accessor.get("normalized"):
            return rows
        return [tuple(x / {5121: 255, 5123: 65535}[accessor["componentType"]] for x in row) for row in rows]

    def clips(self):
        """Name to Tracks."""
        found = {}
        for animation in self.json.get("animations", []):
            tracks = found[animation["name"]] = Tracks()
            for channel in animation["channels"]:
                sampler, target = animation["samplers"][channel["sampler"]], channel["target"]
                if target["path"] in REST:
                    times = [time for (time,) in self.rows(sampler["input"])]
                    tracks[target["node"], target["path"]] = times, self.rows(sampler["output"])
        return found

    def local(self, n, tracks=None, time=0):
        node = self.nodes[n]
        keyed = [path for path in REST if tracks and (n, path) in tracks]
        if "matrix" in node and not keyed:
            return of_columns(node["matrix"])
        return composed(*(tracks.at(n, path, time) if path in keyed else node.get(path, rest)
                          for path, rest in REST.items()))

    def palette(self, tracks, time):
        """Name to the matrix that takes rest space to the world, of each joint of all skins; the first of a name."""
        world = {-1: IDENTITY}

        def reach(n):
            if n not in world:
                world[n] = product(reach(self.parent[n]), self.local(n, tracks, time))
            return world[n]

        palette = {}
        for skin in self.json["skins"]:
            for n, bind in zip(skin["joints"], self.rows(skin["inverseBindMatrices"])):
                palette.setdefault(self.nodes[n].get("name"), product(reach(n), of_columns(bind)))
        return palette

    def primitives(self):
        """(name, skin, attributes, indices) of each primitive at each skinned node."""
        for node in self.nodes:
            if "mesh" in node and "skin" in node:
                for p in self.json["meshes"][node["mesh"]]["primitives"]:
                    yield node.get("name"), self.json["skins"][node["skin"]], p["attributes"], p

    def points_of_joints(self, most):
        """Name to rest points that follow each joint, those that follow it the most."""
        found = {}
        for _, skin, attributes, _ in self.primitives():
            points = self.rows(attributes["POSITION"])
            joints_of, weights_of = self.rows(attributes["JOINTS_0"]), self.rows(attributes["WEIGHTS_0"])
            for x, joints, weights in zip(points, joints_of, weights_of):
                for joint, weight in zip(joints, weights):
                    if weight > 0:
                        found.setdefault(self.nodes[skin["joints"][joint]].get("name"), []).append((weight, x))
        return {name: [x for _, x in sorted(points, reverse=True)[:most]] for name, points in found.items()}


def changed(source, path, change):
    """Writes the GLB with `change` made to its JSON and its bytes; returns the path."""
    data = pathlib.Path(source).read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    document, binary = json.loads(data[20:20 + size]), bytearray(data[28 + size:])
    change(document, binary)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A) + text +
                     struct.pack("<II", len(binary), 0x004E4942) + binary)
    return path


def multiplied(factor):
    """A change that makes all points of all meshes so many times as far from the origin."""
    def change(document, binary):
        for accessor in {p["attributes"]["POSITION"] for mesh in document["meshes"] for p in mesh["primitives"]}:
            accessor = document["accessors"][accessor]
            view = document["bufferViews"][accessor["bufferView"]]
            begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            for i in range(accessor["count"]):
                at = begin + i * view.get("byteStride", 12)
                struct.pack_into("<3f", binary, at, *(factor * x for x in struct.unpack_from("<3f", binary, at)))
    return change
