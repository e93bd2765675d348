// SPDX-License-Identifier: MIT
#include "tools/drawing/sheet.h"

#include <algorithm>
#include <cmath>

#include "formats/file.h"
#include "formats/images.h"
#include "formats/slod.h"
#include "pipeline/closest.h"
#include "pipeline/error.h"
#include "pipeline/repair.h"
#include "tools/command_line.h"
#include "tools/drawing/offscreen.h"
#include "tools/drawing/renderer.h"
#include "tools/input.h"
#include "tools/table.h"

namespace skinlod {
namespace {

struct SheetArguments {
  std::string slod, source, output, about;
  std::vector<std::string> clips, morphs;
  int poses = 3, height = 480, turn = 30;
  bool rest = false, error = false;
};

bool parse(SheetArguments& a, std::span<const std::string> args, std::ostream& out) {
  CommandLine line(
      "", "HERO.slod --source HERO.glb -o HERO.png [options]",
      "Draws the levels of a .slod side by side in poses of the source's clips, a row for each pose, with\n"
      "the shader that ships. The inner side of one-sided materials is red.",
      "skinlod_sheet");
  line.input("HERO.slod", a.slod, "what skinlod cook wrote");
  line.word("--source", "FILE", a.source, "the character it was made of: for clips and images");
  line.word("-o,--output", "FILE", a.output, "the PNG to write; - is stdout");
  line.words("--clips", "FILE", a.clips, "more clips, bound to the joints by name; may be repeated");
  line.number("--poses", "COUNT", a.poses, 0, 100, "bent poses, each the farthest from those before it");
  line.flag("--rest", a.rest, "the bind pose too, first");
  line.words("--morph", "NAME=WEIGHT", a.morphs,
             "a row more for each pose, with this morph target on; may be repeated: all are on at once");
  line.flag(
      "--error", a.error,
      "two rows for each pose: the source by its distance from the level, the level by its distance from "
      "the source");
  line.word("--about", "JOINT", a.about, "show only what is near the vertices that follow this joint most");
  line.number("--turn", "DEGREES", a.turn, -360, 360, "how far the eye stands to the right of +z");
  line.number("--height", "PIXELS", a.height, 16, 4096, "of a row");
  if (!line.parse(args, out)) return false;
  for (const auto& [option, value] : {std::pair("--source", &a.source), std::pair("-o", &a.output)}) {
    if (value->empty()) throw Error{Fault::Usage, std::string(option) + ": is missing: see --help"};
  }
  return true;
}

// The weights of all morphs: those at rest, and over them those of the command line.
std::vector<float> morph_weights(const slod_file& file, const std::vector<std::string>& given) {
  std::vector<float> weights;
  for (std::uint32_t m = 0; m < slod_count(&file, SLOD_MORPHS); ++m) {
    weights.push_back(slod_get_morph(&file, m).weight);
  }
  for (const std::string& word : given) {
    const size_t equals = word.rfind('=');
    const std::string name = word.substr(0, equals);
    char* end = nullptr;
    const float weight = equals == std::string::npos ? 0 : std::strtof(word.c_str() + equals + 1, &end);
    bool found = false;
    for (std::uint32_t m = 0; m < weights.size(); ++m) {
      if (slod_name(&file, slod_get_morph(&file, m).name) == name) weights[m] = weight, found = true;
    }
    if (!end || *end || !found) {
      throw Error{Fault::Usage,
                  "--morph: " + word + ": is no morph target and its weight: see skinlod inspect"};
    }
  }
  return weights;
}

std::vector<Pose> bent_poses(const Character& character, const SheetArguments& a) {
  PoseOptions options{
      .from_clips = a.poses, .range_of_motion = 0, .unseen_clip_frames = 0, .unseen_range_of_motion = 0};
  if (character.clips.empty()) std::swap(options.from_clips, options.range_of_motion);
  std::vector<Pose> poses = choose_poses(character, options).examples;
  if (!a.rest) poses.erase(poses.begin());
  if (poses.empty()) throw Error{Fault::Usage, "--poses: none is left to draw: ask for more, or for --rest"};
  return poses;
}

// Shows all vertices of all levels, or what is before and behind those of the source that follow the joint
// named most.
View framed(const SlodFile& read, const Pose& pose, const SheetArguments& a) {
  std::vector<Vec3> all, near;
  for (const auto& level : read.levels) {
    const std::vector<Vec3> points = pose_vertices(level.surface, pose.palette);
    all.insert(all.end(), points.begin(), points.end());
  }
  View view = View::around(all, a.turn);
  if (a.about.empty()) return view;
  const Skeleton& skeleton = read.character.skeleton;
  const Surface& source = read.levels[0].surface;
  for (size_t v = 0; v < source.position.size(); ++v) {
    const Influence& most = *std::ranges::max_element(source.influences[v], {}, &Influence::weight);
    const int node = skeleton.joints[size_t(most.joint)].node;
    if (skeleton.nodes[size_t(node)].name == a.about) near.push_back(all[v]);
  }
  if (near.empty()) throw Error{Fault::Usage, "--about: " + a.about + ": no vertex follows it most"};
  const View close = View::around(near, a.turn);
  view.centre.head<2>() = close.centre.head<2>(), view.size.head<2>() = close.size.head<2>();
  return view;
}

// The distance of each render vertex of one level from another level in a pose, metres.
std::vector<float> distances(const Surface& from, const Surface& to, const Palette& palette) {
  const PosedSurface surface(to, pose_vertices(to, palette));
  const std::vector<Vec3> points = pose_vertices(from, palette);
  std::vector<float> of_vertex, of_wedge;
  for (const Vec3& x : points) of_vertex.push_back(float(std::sqrt(surface.closest(x).squared)));
  for (const Wedge& w : from.wedges) of_wedge.push_back(of_vertex[size_t(w.vertex)]);
  return of_wedge;
}

// The rows and columns of pictures and what is written above and in them.
struct Sheet {
  int cell_width, cell_height;
  Picture picture;

  static constexpr int kBand = 24;  // pixels, of a line of text
  Sheet(int columns, int rows, int width, int height)
      : cell_width(width), cell_height(height), picture(columns * width, kBand * 2 + rows * height) {}
  void put(const Picture& cell, int column, int row, const std::string& label) {
    const int x = column * cell_width, y = 2 * kBand + row * cell_height;
    paste(picture, cell, x, y);
    write_text(picture, label, x + 6, y + 6);
  }
  void title(const std::string& text) { write_text(picture, text, 6, 5); }
  void head(int column, const std::string& text) {
    write_text(picture, text, column * cell_width + 6, kBand + 5);
  }
};

std::string millimetres(double metres) { return rounded(1000 * metres) + " mm"; }

// All that is drawn comes from `file`; the pipeline's reading of it gives distances.
struct Drawing {
  const slod_file& file;
  const SlodFile& read;
  std::vector<Pose> poses;
  std::vector<View> views;                 // of each pose
  std::vector<std::vector<float>> morphs;  // a row of each pose for each: their weights
};

void draw_levels(const Drawing& d, Renderer& renderer, Sheet& sheet) {
  sheet.title(d.read.character.name);
  for (std::uint32_t l = 0; l < d.file.level_count; ++l) {
    for (size_t m = 0; m < d.morphs.size(); ++m) {
      const GpuLevel level(d.file, l, d.morphs[m]);
      for (size_t p = 0; p < d.poses.size(); ++p) {
        const std::string label = d.poses[p].source + (m > 0 ? ", morphs" : "");
        sheet.put(renderer.draw(level, packed(d.poses[p].palette), d.views[p]), int(l),
                  int(p * d.morphs.size() + m), l == 0 ? label : "");
      }
    }
  }
}

// Of the diagonal: the distance that is black.
constexpr double kBlack = 0.03;

void draw_errors(const Drawing& d, Renderer& renderer, Sheet& sheet) {
  const GpuLevel plain(d.file, 0);
  GpuLevel source(d.file, 0);
  const Surface& original = d.read.levels[0].surface;
  const double black = kBlack * diagonal(original.position);
  sheet.title(d.read.character.name + ": the source, and below it the level, by their distance: black is " +
              millimetres(black));
  for (std::uint32_t l = 1; l < d.file.level_count; ++l) {
    GpuLevel level(d.file, l);
    const Surface& surface = d.read.levels[l].surface;
    for (size_t p = 0; p < d.poses.size(); ++p) {
      const Palette& palette = d.poses[p].palette;
      const auto put = [&](GpuLevel& shown, std::vector<float> metres, int row) {
        const double largest = double(*std::ranges::max_element(metres));
        for (float& x : metres) x = float(x / black);
        shown.show(metres);
        sheet.put(renderer.draw_values(shown, packed(palette), d.views[p]), int(l), row,
                  "up to " + millimetres(largest));
      };
      put(source, distances(original, surface, palette), int(2 * p));
      put(level, distances(surface, original, palette), int(2 * p + 1));
    }
  }
  for (size_t p = 0; p < d.poses.size(); ++p) {
    sheet.put(renderer.draw(plain, packed(d.poses[p].palette), d.views[p]), 0, int(2 * p), d.poses[p].source);
  }
}

}  // namespace

int draw_sheet(std::span<const std::string> args, std::ostream& out) {
  SheetArguments a;
  if (!parse(a, args, out)) return 0;
  const auto bytes = read_file(a.slod);
  const SlodFile read = read_slod(bytes, file_name(a.slod));
  slod_file file;
  slod_open(bytes.data(), bytes.size(), &file);  // read_slod has said what is wrong with it
  Imported source = import_character(a.source);
  add_clips(source, a.clips, {});
  repair(source.character);
  if (source.character.skeleton.joints.size() != slod_count(&file, SLOD_JOINTS)) {
    throw Error{Fault::Input, file_name(a.slod) + ": was not made of " + file_name(a.source) +
                                  ": it has other joints: cook it again"};
  }

  Drawing d{file, read, bent_poses(source.character, a), {}, {morph_weights(file, {})}};
  if (!a.morphs.empty()) d.morphs.push_back(morph_weights(file, a.morphs));
  double wide = 0;  // for its height
  for (const Pose& pose : d.poses) {
    const View& view = d.views.emplace_back(framed(read, pose, a));
    wide = std::max(wide, view.size.x() / view.size.y());
  }
  const int width = int(a.height * std::clamp(wide, 0.65, 1.5));
  const int rows = int(d.poses.size()) * (a.error ? 2 : int(d.morphs.size()));
  Sheet sheet(int(file.level_count), rows, width, a.height);
  for (std::uint32_t l = 0; l < file.level_count; ++l) {
    const slod_level level = slod_get_level(&file, l);
    sheet.head(int(l), (l == 0 ? "source: " : "LOD" + std::to_string(l) + ": ") +
                           grouped(level.triangle_count) + " triangles");
  }

  const Offscreen offscreen;
  std::vector<Picture> images;
  for (const auto& encoded : base_colour_images(source, a.source)) images.push_back(decode_image(encoded));
  Renderer renderer(file, images, width, a.height);
  if (a.error) {
    draw_errors(d, renderer, sheet);
  } else {
    draw_levels(d, renderer, sheet);
  }
  write_file(a.output, png(sheet.picture));
  return 0;
}

}  // namespace skinlod
