// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/character.h"

namespace skinlod {

/// What is averaged apart: characters that bend everywhere, characters of near-rigid pieces, and generated
/// shapes, which bend so evenly that what knows of the rest pose alone fails on them by a factor of 100.
inline constexpr std::array<const char*, 3> kKinds = {"deforming", "near_rigid", "shape"};

/// A character that the bench looks at.
struct Subject {
  std::string name;                 // folder and file, or the shape's
  std::string kind;                 // one of kKinds
  std::function<Character()> make;  // repaired and welded
};

struct SubjectOptions {
  std::vector<std::string> only{};  // words, one of which a name must hold; none: all
  std::string folder{};             // of other people's characters; may be missing
};

/// The folder of other people's characters where it lies beside the repository.
std::string shared_characters();

/// The generated shapes, content/ and the characters of the folder, which tools/characters.json knows of.
/// Throws Error{Usage} where there is none.
std::vector<Subject> subjects(const SubjectOptions& options);

/// The character of a file, with its clips from other files, repaired and welded.
Character load_character(const std::string& path, const std::vector<std::string>& clips = {});

/// Without seams: its surface has no attributes and one part.
Character with_seams_free(const Character& character);

/// The same surface with every triangle cut into n x n: midpoints for n = 2. Points, attributes and weights
/// between are blended linearly, so the surface stays where it is at rest. Morphs are dropped.
Surface subdivided(const Surface& surface, int n);

}  // namespace skinlod
