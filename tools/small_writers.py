# SPDX-License-Identifier: MIT
"""Writes a Glb (small_glb.py) as DirectX X and as Ogre's XML, for check_importers.py: what nothing in Debian does."""
import math

from small_glb import of_columns


def numbers(values):
    """With a point in each: Assimp would take a comma for one."""
    return ",".join(f"{x:.9f}" for x in values)


# ---- X: left-handed, row vectors

MIRROR = (1, 1, -1, 1)


def x_matrix(m):
    rows = list(m) + [(0, 0, 0, 1)]
    return numbers(MIRROR[r] * MIRROR[c] * rows[c][r] for r in range(4) for c in range(4))


def x_list(items):
    return ",\n".join(items) + ";"


def x_mesh(glb, skin, attributes, primitive):
    mirrored = [[f"{x:.9f};{y:.9f};{-z:.9f};" for x, y, z in glb.rows(attributes[of])] for of in ("POSITION", "NORMAL")]
    corners = [i for (i,) in glb.rows(primitive["indices"])]
    faces = x_list([f"3;{a},{c},{b};" for a, b, c in zip(*[iter(corners)] * 3)])  # turned over by the mirror
    points, normals = (f"{len(rows)};\n{x_list(rows)}\n" for rows in mirrored)
    faces = f"{len(corners) // 3};\n{faces}\n"
    follow = {}
    for v, (joints, weights) in enumerate(zip(glb.rows(attributes["JOINTS_0"]), glb.rows(attributes["WEIGHTS_0"]))):
        for joint, weight in zip(joints, weights):
            if weight > 0:
                follow.setdefault(joint, []).append((v, weight))
    binds = glb.rows(skin["inverseBindMatrices"])
    skins = "".join(
        f'SkinWeights {{\n"{glb.nodes[skin["joints"][j]]["name"]}";\n{len(its)};\n{",".join(str(v) for v, _ in its)};\n'
        f'{numbers(w for _, w in its)};\n{x_matrix(of_columns(binds[j]))};;\n}}\n' for j, its in sorted(follow.items()))
    return (f"Mesh {{\n{points}{faces}MeshNormals {{\n{normals}{faces}}}\n"
            f"XSkinMeshHeader {{ 4; 12; {len(follow)}; }}\n{skins}}}\n")


def x_frames(glb, n):
    node = glb.nodes[n]
    inside = "".join(x_frames(glb, child) for child in node.get("children", []))
    if "skin" in node:
        skin = glb.json["skins"][node["skin"]]
        primitives = glb.json["meshes"][node["mesh"]]["primitives"]
        inside += "".join(x_mesh(glb, skin, p["attributes"], p) for p in primitives)
    return f'Frame {node["name"]} {{\nFrameTransformMatrix {{ {x_matrix(glb.local(n))};; }}\n{inside}}}\n'


def x_clip(glb, name, tracks):
    ticks = 4800
    keyed = []
    for n in sorted({node for node, _ in tracks}):
        times = sorted({t for (node, _), (keys, _) in tracks.items() if node == n for t in keys})
        rows = x_list([f"{round(ticks * t)};16;{x_matrix(glb.local(n, tracks, t))};;" for t in times])
        keyed.append(f'Animation {{ {{ {glb.nodes[n]["name"]} }} AnimationKey {{ 4;\n{len(times)};\n{rows} }} }}\n')
    return f"AnimationSet {name} {{\n{''.join(keyed)}}}\n"


def write_x(glb, path):
    frames = "".join(x_frames(glb, n) for n in range(len(glb.nodes)) if glb.parent[n] < 0)
    clips = "".join(x_clip(glb, name, tracks) for name, tracks in glb.clips().items())
    path.write_text(f"xof 0303txt 0032\nAnimTicksPerSecond {{ 4800; }}\n{frames}{clips}")
    return path


# ---- Ogre: a skeleton of turns and moves from the rest pose

def xml_vector(tag, v):
    return f'<{tag} x="{v[0]:.9g}" y="{v[1]:.9g}" z="{v[2]:.9g}"/>'


def xml_turn(tag, q):
    length = math.sqrt(sum(x * x for x in q[:3]))
    axis = tuple(x / length for x in q[:3]) if length else (1, 0, 0)
    return f'<{tag} angle="{2 * math.atan2(length, q[3]):.9g}">{xml_vector("axis", axis)}</{tag}>'


def turned_back(q, by):
    """The turn that comes after the inverse of `by` to make `q`."""
    (x, y, z, w), (p, q, r, s) = (-by[0], -by[1], -by[2], by[3]), q
    return (w * p + x * s + y * r - z * q, w * q - x * r + y * s + z * p, w * r + x * q - y * p + z * s,
            w * s - x * p - y * q - z * r)


def ogre_track(glb, n, tracks):
    node = glb.nodes[n]
    place, turn = node.get("translation", (0, 0, 0)), node.get("rotation", (0, 0, 0, 1))
    frames = ""
    for time in sorted({t for path in ("translation", "rotation") if (n, path) in tracks for t in tracks[n, path][0]}):
        to = tracks.at(n, "translation", time) if (n, "translation") in tracks else place
        by = tracks.at(n, "rotation", time) if (n, "rotation") in tracks else turn
        frames += (f'<keyframe time="{time:.9g}">{xml_vector("translate", [a - b for a, b in zip(to, place)])}'
                   f'{xml_turn("rotate", turned_back(by, turn))}</keyframe>')
    return f'<track bone="{node["name"]}"><keyframes>{frames}</keyframes></track>' if frames else ""


def ogre_submesh(glb, attributes, primitive):
    points, normals = glb.rows(attributes["POSITION"]), glb.rows(attributes["NORMAL"])
    vertices = "".join(f'<vertex>{xml_vector("position", p)}{xml_vector("normal", n)}</vertex>'
                       for p, n in zip(points, normals))
    corners = [i for (i,) in glb.rows(primitive["indices"])]
    faces = "".join(f'<face v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in zip(*[iter(corners)] * 3))
    follow = zip(glb.rows(attributes["JOINTS_0"]), glb.rows(attributes["WEIGHTS_0"]))
    weights = "".join(f'<vertexboneassignment vertexindex="{v}" boneindex="{j}" weight="{w:.9g}"/>'
                      for v, (js, ws) in enumerate(follow) for j, w in zip(js, ws) if w > 0)
    return (f'<submesh material="m" usesharedvertices="false" use32bitindexes="true" operationtype="triangle_list">'
            f'<faces count="{len(corners) // 3}">{faces}</faces><geometry vertexcount="{len(points)}">'
            f'<vertexbuffer positions="true" normals="true">{vertices}</vertexbuffer></geometry>'
            f'<boneassignments>{weights}</boneassignments></submesh>')


def write_ogre(glb, path):
    """Of one skin whose joints rest as they are bound, below nodes that change nothing."""
    joints, bones = glb.json["skins"][0]["joints"], ""
    for i, n in enumerate(joints):
        place, turn = glb.nodes[n].get("translation", (0, 0, 0)), glb.nodes[n].get("rotation", (0, 0, 0, 1))
        bones += (f'<bone id="{i}" name="{glb.nodes[n]["name"]}">{xml_vector("position", place)}'
                  f'{xml_turn("rotation", turn)}</bone>')
    hierarchy = "".join(f'<boneparent bone="{glb.nodes[n]["name"]}" parent="{glb.nodes[glb.parent[n]]["name"]}"/>'
                        for n in joints if glb.parent[n] in joints)
    clips = ""
    for name, tracks in glb.clips().items():
        end = max(keys[-1] for keys, _ in tracks.values())
        clips += (f'<animation name="{name}" length="{end:.9g}"><tracks>'
                  f'{"".join(ogre_track(glb, n, tracks) for n in joints)}</tracks></animation>')
    submeshes = "".join(ogre_submesh(glb, attributes, primitive) for _, _, attributes, primitive in glb.primitives())
    skeleton = path.name.replace(".mesh.xml", ".skeleton")
    path.write_text(f'<mesh><submeshes>{submeshes}</submeshes><skeletonlink name="{skeleton}"/></mesh>')
    path.with_name(skeleton + ".xml").write_text(f'<skeleton><bones>{bones}</bones><bonehierarchy>{hierarchy}'
                                                 f'</bonehierarchy><animations>{clips}</animations></skeleton>')
    return path
