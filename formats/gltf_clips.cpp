// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "formats/gltf_accessor.h"
#include "formats/gltf_read.h"

namespace skinlod {
namespace {

std::optional<Path> path_of(const std::string& name) {
  if (name == "translation") return Path::Translation;
  if (name == "rotation") return Path::Rotation;
  if (name == "scale") return Path::Scale;
  if (name == "weights") return Path::MorphWeights;
  return {};
}

std::optional<Interpolation> interpolation_of(const std::string& name) {
  if (name == "LINEAR") return Interpolation::Linear;
  if (name == "STEP") return Interpolation::Step;
  if (name == "CUBICSPLINE") return Interpolation::CubicSpline;
  return {};
}

Rows read_values(const GltfDocument& doc, int accessor, Path path) {
  switch (path) {
    case Path::Rotation:
      return read_rows(doc, accessor, Legal::Keys, {TINYGLTF_TYPE_VEC4});
    case Path::MorphWeights:
      return read_rows(doc, accessor, Legal::Keys, {TINYGLTF_TYPE_SCALAR});
    default:
      return read_rows(doc, accessor, Legal::Float, {TINYGLTF_TYPE_VEC3});
  }
}

// The channel with its keys; its part of the file is `part`.
Channel read_channel(const GltfDocument& doc, const std::string& part, const tinygltf::AnimationChannel& from,
                     Path path, const tinygltf::AnimationSampler& sampler) {
  const std::optional<Interpolation> interpolation = interpolation_of(sampler.interpolation);
  if (!interpolation) doc.fail(part, "has the unknown interpolation " + sampler.interpolation);
  const Rows times = read_rows(doc, sampler.input, Legal::Float, {TINYGLTF_TYPE_SCALAR});
  Rows values = read_values(doc, sampler.output, path);
  const Eigen::Index rows = times.rows() * (interpolation == Interpolation::CubicSpline ? 3 : 1);
  const Eigen::Index columns =
      path == Path::MorphWeights ? target_count(doc, from.target_node) : values.cols();
  if (values.size() != rows * columns) {
    doc.fail(part, "has " + std::to_string(values.rows()) + " values for " + std::to_string(times.rows()) +
                       " keys");
  }
  if (path == Path::MorphWeights) values = Rows(Eigen::Map<const Rows>(values.data(), rows, columns));
  return {
      from.target_node, path, *interpolation, {times.data(), times.data() + times.size()}, std::move(values)};
}

}  // namespace

std::vector<Clip> read_clips(GltfDocument& doc, Warnings& warnings) {
  std::vector<Clip> clips;
  size_t numbers = 0;  // keys and their values: channels can share them
  const size_t most = 4 * doc.most_elements();
  for (size_t a = 0; a < doc.model.animations.size(); ++a) {
    const tinygltf::Animation& animation = doc.model.animations[a];
    Clip& clip = clips.emplace_back();
    clip.name = animation.name.empty() ? numbered("animation", a) : animation.name;
    Json kept = Json::array();
    std::set<std::pair<int, Path>> moved;
    for (size_t c = 0; c < animation.channels.size(); ++c) {
      const tinygltf::AnimationChannel& from = animation.channels[c];
      const std::string part = numbered("animation", a) + ": " + numbered("channel", c);
      if (size_t(from.sampler) >= animation.samplers.size()) doc.fail(part, "its sampler does not exist");
      if (from.target_node >= int(doc.model.nodes.size())) doc.fail(part, "its node does not exist");
      const Json& as_written = doc.json["animations"][a]["channels"][c];
      const std::optional<Path> path = path_of(from.target_path);
      if (from.target_node < 0 || !path ||
          (path == Path::MorphWeights && target_count(doc, from.target_node) == 0)) {
        warn(warnings, {WarningCode::ClipChannelsUnbound, clip.name, 1, "left out"});
        kept.push_back(as_written);
        continue;
      }
      const tinygltf::AnimationSampler& sampler = animation.samplers[size_t(from.sampler)];
      for (const int accessor : {sampler.input, sampler.output}) {
        if (accessor >= 0 && size_t(accessor) < doc.model.accessors.size())
          numbers += std::min(doc.model.accessors[size_t(accessor)].count, most + 1);
      }
      if (numbers > most) {
        doc.fail(part, "brings the keys and values of all clips to more than the " + std::to_string(most) +
                           " that a file of this size has");
      }
      Channel channel = read_channel(doc, part, from, *path, sampler);
      const bool finite = std::all_of(channel.times.begin(), channel.times.end(),
                                      [](double time) { return std::isfinite(time); });
      if (!finite || !channel.values.allFinite()) {
        warn(warnings, {WarningCode::ClipValuesNotFinite, clip.name, 1, "left out"});
      } else if (!moved.emplace(channel.node, channel.path).second) {
        warn(warnings, {WarningCode::ClipChannelsTwice, clip.name, 1, "left out"});
      } else {
        clip.channels.push_back(std::move(channel));
        kept.push_back(as_written);
      }
    }
    doc.json["animations"][a]["channels"] = std::move(kept);
  }
  return clips;
}

int target_count(const GltfDocument& doc, int node) {
  const int mesh = doc.model.nodes[size_t(node)].mesh;
  if (mesh < 0 || size_t(mesh) >= doc.model.meshes.size()) return 0;
  size_t count = 0;
  for (const tinygltf::Primitive& primitive : doc.model.meshes[size_t(mesh)].primitives) {
    count = std::max(count, primitive.targets.size());
  }
  return int(count);
}

}  // namespace skinlod
