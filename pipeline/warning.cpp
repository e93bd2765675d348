// SPDX-License-Identifier: MIT
#include "pipeline/warning.h"

#include <algorithm>

namespace skinlod {

Explanation explain(WarningCode code) {
  switch (code) {  // no default: the compiler tells of a code without an explanation
    case WarningCode::WeightsNotNormalised:
      return {"weights-not-normalised", "The influences of vertices sum to something else than 1.",
              "They were divided by their sum.", "Normalise all weights before the export."};
    case WarningCode::WeightsNegative:
      return {"weights-negative", "Vertices have weights below 0.",
              "Those were set to 0, and the others divided by their sum.",
              "Remove them where the weights are painted, and normalise."};
    case WarningCode::WeightsAbsent:
      return {"weights-absent", "Vertices follow no joint at all.",
              "Each follows what the nearest vertex of its part follows, or else the node of its part.",
              "Bind them, or paint their weights."};
    case WarningCode::WeightsNotFinite:
      return {"weights-not-finite", "Weights are infinite or no numbers.", "They were set to 0.",
              "Export again; if they come back, paint those weights anew."};
    case WarningCode::PositionNotFinite:
      return {"position-not-finite",
              "Vertices stand at infinity, at no number, or more than 1e12 metres away.",
              "Their faces were removed.", "Look for broken modifiers or scales, and export again."};
    case WarningCode::AttributeNotFinite:
      return {"attribute-not-finite", "Normals, tangents, uvs or colours are infinite or no numbers.",
              "They have their defaults now.", "Recompute the normals or unwrap those faces again."};
    case WarningCode::FaceDegenerate:
      return {"face-degenerate", "Faces have two equal corners or no area.",
              "They were removed; a doubled corner of a larger face was.",
              "Merge vertices by distance and delete loose or zero-area faces."};
    case WarningCode::FaceDuplicate:
      return {"face-duplicate", "Faces are there more than once, with the same corners in the same turn.",
              "One of each was kept.", "Delete the copies: they flicker and cost triangles."};
    case WarningCode::FaceOutOfRange:
      return {"face-out-of-range", "Faces name vertices that are not there.", "They were removed.",
              "The exporter is at fault: export again or with another one."};
    case WarningCode::JointUnused:
      return {"joint-unused", "No vertex follows these joints.",
              "They were kept: attachments and clips may want them.",
              "None is needed; leave them out of the skin to save their matrices."};
    case WarningCode::JointNameClash:
      return {"joint-name-clash", "Several nodes have one name.",
              "Clips that are bound by name take the first.", "Give every node a name of its own."};
    case WarningCode::PartsCoincide:
      return {"parts-coincide",
              "Vertices share a place but not their influences or morphs, so that some pose parts them.",
              "They were kept apart, and may come apart further in coarser levels.",
              "If they should hold together, give them the same weights; between rigid parts it is as "
              "it must be."};
    case WarningCode::InfluencesOutOfRange:
      return {"influences-out-of-range", "Influences name joints that are not in the skin.",
              "They were removed.", "The exporter is at fault: bind the mesh again and export."};
    case WarningCode::ClipChannelsUnbound:
      return {"clip-channels-unbound", "Channels of a clip move nodes that the character does not have.",
              "They were left out.", "Give clips made for this skeleton, with its node names."};
    case WarningCode::ClipValuesNotFinite:
      return {"clip-values-not-finite", "Channels have infinite times or values, or too few of them.",
              "They were left out.", "Bake the clip and export it again."};
    case WarningCode::ClipKeysCoincide:
      return {"clip-keys-coincide", "Keys of a channel stand at one time.", "The last of them was kept.",
              "Remove doubled keys, or sample the clip at fixed steps."};
    case WarningCode::MorphTangentsDropped:
      return {"morph-tangents-dropped", "Morph targets move tangents too.",
              "Those offsets were left out; positions and normals are carried.",
              "None is needed: engines derive tangents from normals and uvs."};
    case WarningCode::MaterialPropertyLost:
      return {"material-property-lost", "The output cannot say all that a material of the source does.",
              "Name, colour, base texture and sidedness were kept.",
              "Give a glTF source, as the first file of several, to keep materials in full."};
    case WarningCode::NonManifoldEdges:
      return {"non-manifold-edges", "Edges have more than two faces.",
              "They were kept, and hold as lines that are not joined to others.",
              "Remove inner faces where nobody looks: they cost triangles in every level."};
    case WarningCode::NotASkinFeature:
      return {"not-a-skin-feature",
              "The file has cameras, lights, points, lines or attributes of an application.",
              "A glTF source keeps cameras and lights; all else was left out.", "None is needed."};
    case WarningCode::WeightsNearlyEqual:
      return {"weights-nearly-equal", "Vertices at one place have weights that differ by rounding only.",
              "They were joined, with the weights of the first.", "None is needed."};
    case WarningCode::ClipUnitsScaled:
      return {"clip-units-scaled", "A clip file is in another unit than the character.",
              "Its translations were scaled by the ratio of bone lengths.", "Export both in one unit."};
    case WarningCode::ClipKeysUnsorted:
      return {"clip-keys-unsorted", "Keys were not in the order of their times.", "They were sorted.",
              "The exporter is at fault; none is needed."};
    case WarningCode::ClipChannelsTwice:
      return {"clip-channels-twice",
              "Two channels of a clip move the same thing, in one file or in clips of one name in "
              "several.",
              "The first one was kept.", "Remove the second, or give the clips names of their own."};
    case WarningCode::SceneNodeTwice:
      return {"scene-node-twice", "A scene lists a node more than once.", "It was listed once.",
              "The exporter is at fault; none is needed."};
    case WarningCode::MeshOutsideScene:
      return {"mesh-outside-scene", "Nodes with a mesh are not in the scene that is shown.",
              "They were left out.", "Put them into the default scene if they belong to the character."};
    case WarningCode::FaceIncomplete:
      return {"face-incomplete", "Indices are left behind the last whole triangle.", "They were left out.",
              "The exporter is at fault: look whether a face is missing."};
    case WarningCode::RotationZero:
      return {"rotation-zero", "The rotation of nodes is all zeros, which is no rotation.",
              "They are not turned.", "Reset those nodes' rotations and export again."};
    case WarningCode::ExtensionDropped:
      return {"extension-dropped",
              "A file that is not the first of several has extensions, extras or cameras that only its "
              "own document could say.",
              "They were left out; its materials, textures, meshes and clips are carried.",
              "Give that file first, or add them to the first one."};
  }
  return {"unknown", "", "", ""};
}

std::string_view name(WarningCode code) { return explain(code).name; }

std::vector<WarningCode> warning_codes() {
  std::vector<WarningCode> all;
  for (int code = 0; name(WarningCode(code)) != "unknown"; ++code) all.push_back(WarningCode(code));
  return all;
}

void warn(Warnings& warnings, Warning warning) {
  if (warning.count == 0) return;
  const auto same = std::find_if(warnings.begin(), warnings.end(), [&](const Warning& w) {
    return w.code == warning.code && w.part == warning.part && w.detail == warning.detail;
  });
  if (same != warnings.end()) {
    same->count += warning.count;
  } else {
    warnings.push_back(std::move(warning));
  }
}

std::string text(const Warning& warning) {
  std::string line = warning.part.empty() ? "" : warning.part + ": ";
  line += std::to_string(warning.count) + " x " + std::string(name(warning.code));
  if (!warning.detail.empty()) line += " (" + warning.detail + ")";
  return line;
}

}  // namespace skinlod
