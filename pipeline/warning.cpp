// SPDX-License-Identifier: MIT
#include "pipeline/warning.h"

#include <algorithm>

namespace skinlod {

std::string_view name(WarningCode code) {
  switch (code) {  // no default: the compiler tells of a code without a name
    case WarningCode::WeightsNotNormalised:
      return "weights-not-normalised";
    case WarningCode::WeightsNegative:
      return "weights-negative";
    case WarningCode::WeightsAbsent:
      return "weights-absent";
    case WarningCode::WeightsNotFinite:
      return "weights-not-finite";
    case WarningCode::PositionNotFinite:
      return "position-not-finite";
    case WarningCode::AttributeNotFinite:
      return "attribute-not-finite";
    case WarningCode::FaceDegenerate:
      return "face-degenerate";
    case WarningCode::FaceDuplicate:
      return "face-duplicate";
    case WarningCode::FaceOutOfRange:
      return "face-out-of-range";
    case WarningCode::JointUnused:
      return "joint-unused";
    case WarningCode::JointNameClash:
      return "joint-name-clash";
    case WarningCode::PartsCoincide:
      return "parts-coincide";
    case WarningCode::InfluencesOutOfRange:
      return "influences-out-of-range";
    case WarningCode::ClipChannelsUnbound:
      return "clip-channels-unbound";
    case WarningCode::ClipValuesNotFinite:
      return "clip-values-not-finite";
    case WarningCode::ClipKeysCoincide:
      return "clip-keys-coincide";
    case WarningCode::MorphTangentsDropped:
      return "morph-tangents-dropped";
    case WarningCode::MaterialPropertyLost:
      return "material-property-lost";
    case WarningCode::NonManifoldEdges:
      return "non-manifold-edges";
    case WarningCode::NotASkinFeature:
      return "not-a-skin-feature";
    case WarningCode::WeightsNearlyEqual:
      return "weights-nearly-equal";
    case WarningCode::ClipUnitsScaled:
      return "clip-units-scaled";
    case WarningCode::ClipKeysUnsorted:
      return "clip-keys-unsorted";
    case WarningCode::ClipChannelsTwice:
      return "clip-channels-twice";
    case WarningCode::SceneNodeTwice:
      return "scene-node-twice";
    case WarningCode::MeshOutsideScene:
      return "mesh-outside-scene";
    case WarningCode::FaceIncomplete:
      return "face-incomplete";
    case WarningCode::RotationZero:
      return "rotation-zero";
  }
  return "unknown";
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
