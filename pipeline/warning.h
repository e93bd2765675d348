// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace skinlod {

/// What an import found wrong, or changed, or could not take along. A code never changes its meaning.
enum class WarningCode {
  WeightsNotNormalised,  // influences of a vertex summed to something else than 1, and were scaled
  WeightsNegative,       // negative weights, set to 0
  WeightsAbsent,         // a vertex without any influence, tied to the joint that fits best
  WeightsNotFinite,      // NaN or infinite weights, set to 0
  PositionNotFinite,     // a vertex at NaN or infinity; its faces were removed
  AttributeNotFinite,    // a normal, tangent, uv or colour that is NaN or infinite, set to its default
  FaceDegenerate,        // a face with two equal corners or without area, removed
  FaceDuplicate,         // a face that is there already, removed
  FaceOutOfRange,        // a face that names a vertex that is not there, removed
  JointUnused,           // joints that no vertex follows; kept
  JointNameClash,        // two nodes of one name: clips bound by name take the first
  PartsCoincide,         // vertices that share a position but not their influences: kept apart
  InfluencesOutOfRange,  // an influence that names a joint that is not there, removed
  ClipChannelsUnbound,   // channels of a clip whose node is not in the skeleton, left out
  ClipValuesNotFinite,   // channels with NaN or infinite times or values, or too few of them, left out
  ClipKeysCoincide,      // keys at the time of the next, by the floats that files hold; left out
  MorphTangentsDropped,  // tangent offsets of morph targets, not carried
  MaterialPropertyLost,  // a property of a material that the output format cannot say
  NonManifoldEdges,      // edges with more than two faces; kept
  NotASkinFeature,       // cameras, lights, points or lines: not part of a character
  WeightsNearlyEqual,    // vertices at one place whose weights differ by rounding only, joined
  ClipUnitsScaled,       // a clip file in another unit: its translations were scaled to the character's
  ClipKeysUnsorted,      // channels whose keys were not in the order of their times, sorted
  ClipChannelsTwice,     // channels that move what another channel of the clip moves, left out
  SceneNodeTwice,        // nodes that a scene lists more than once, listed once
  MeshOutsideScene,      // nodes with a mesh that are not in the scene that is read, left out
  FaceIncomplete,        // indices behind the last whole triangle, left out
  RotationZero,          // nodes whose rotation is all zeros, taken for none
  ExtensionDropped,  // what a file says that is no part of a character, and the output cannot say; left out
};

/// What users are told of a code.
struct Explanation {
  std::string_view name;     // by which reports, `--strict` and scripts know it: "weights-not-normalised"
  std::string_view meaning;  // what is so in the source
  std::string_view done;     // what was done about it
  std::string_view remedy;   // what its maker can do
};
Explanation explain(WarningCode code);

std::string_view name(WarningCode code);

/// Every code, in the order of the enumerators.
std::vector<WarningCode> warning_codes();

/// One kind of finding in one part of the file.
struct Warning {
  WarningCode code;
  std::string part;         // the mesh, clip or joint it was found in; empty for the whole file
  std::int64_t count = 1;   // how many items
  std::string detail = {};  // what was done, in words; may be empty
};

using Warnings = std::vector<Warning>;

/// Adds a warning unless `count` is 0; one of the same code, part and detail is counted up instead.
void warn(Warnings& warnings, Warning warning);

/// "part: 12 x weights-not-normalised (detail)".
std::string text(const Warning& warning);

}  // namespace skinlod
