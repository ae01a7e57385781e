/** @file
 * Alphabet of path words, private to path expressions and path classes: L, S, D, V, E, and further letters L,
 * S and D for lights and surfaces with names. A kind is a set of names that a light or a surface has, out of
 * the names in the expressions; each kind has letters of its own.
 */
#pragma once

#include <bitset>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recurse/pathclasses/pathEvent.h"
#include "recurse/pathclasses/pathNames.h"

namespace recurse {

constexpr size_t PATH_LETTERS = 5; ///< of the alphabet without names
constexpr size_t PATH_EVENTS = 3;
constexpr size_t MAX_LETTERS = 256;

/** Set of letters. */
using LetterSet = std::bitset<MAX_LETTERS>;

class PathAlphabet {
 public:
  /** Names out of those in the expressions, sorted. */
  using Kind = std::vector<std::string>;

  /** The five letters alone. */
  PathAlphabet() : PathAlphabet(std::vector<std::string>{}, nullptr) {}
  /** Letters for the names in the expressions. Without `names`, each name is a kind, and there are lights and
   * surfaces without any. Throws Error if there are too many kinds. */
  PathAlphabet(const std::vector<std::string>& expressions, const PathNames* names);

  size_t size() const { return texts.size(); }
  bool hasNames() const { return size() > PATH_LETTERS; }
  const std::vector<Kind>& lightKinds() const { return lights; }
  const std::vector<Kind>& surfaceKinds() const { return surfaces; }
  /** Letter of an event at a surface of a kind; V has no kinds. */
  size_t event(size_t event, size_t kind) const {
    return kind == 0 || event >= 2 ? event : PATH_LETTERS + 2 * (kind - 1) + event;
  }
  size_t light(size_t kind) const {
    return kind == 0 ? 3 : PATH_LETTERS + 2 * (surfaces.size() - 1) + kind - 1;
  }
  /** One of S, D, V, L, E for any letter. */
  size_t base(size_t letter) const;
  /** All letters of one of S, D, V, L, E. */
  LetterSet lettersOf(size_t base) const;
  LetterSet events() const { return lettersOf(0) | lettersOf(1) | lettersOf(2); }
  /** Letters of L, S or D at lights or surfaces with this name. */
  LetterSet named(size_t base, const std::string& name) const;
  /** Names for lights or surfaces in the scene; those of the expressions where there is no scene. */
  const std::vector<std::string>& knownLights() const { return allLights; }
  const std::vector<std::string>& knownSurfaces() const { return allSurfaces; }
  /** Letter in words for people, such as `D` or `D'floor'`. */
  const std::string& text(size_t letter) const { return texts[letter]; }
  /** Index of the letter at the beginning of the text, which is removed; size() if there is none. */
  size_t take(std::string_view& word) const;
  /** Kinds of each light, object and material, for the tables of walks; the kind of a surface is
   * surfaceKind(object, material). */
  std::vector<uint8_t> lightKindOf, objectKindOf, materialKindOf;
  size_t materialKinds = 1;
  std::vector<uint8_t> surfaceKindOf; ///< by kind of the object · materialKinds + kind of the material

 private:
  void addScene(const PathNames& names, const std::vector<std::string>& used);
  void addTexts();

  std::vector<Kind> lights{Kind()}, surfaces{Kind()};
  std::vector<std::string> allLights, allSurfaces, texts;
};

/** Names of an imagined scene with a light and a surface for each name, and one of each without. */
PathNames anyNames(const std::vector<std::string>& names);
/** Names between quotes in an expression, without a check of its syntax. */
std::vector<std::string> namesIn(std::string_view expression);
std::vector<std::string> namesIn(const std::vector<PathClass>& classes);
/** Reads a quoted name at text[position], `''` being a quote in it; the position becomes that behind it.
 * False if its end is missing. */
bool readQuoted(std::string_view text, size_t& position, std::string& name);
/** A name as expressions write it. */
std::string quotedName(const std::string& name);

} // namespace recurse
