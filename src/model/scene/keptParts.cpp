/** @file
 * Cache keys of scene parts reused between frames.
 */
#include "recurse/model/scene/keptParts.h"

#include "recurse/core/math/hash.h"

namespace recurse {

namespace {

template <class T> void addValues(Hash& hash, const std::vector<T>& values) {
  const uint64_t size = values.size();
  hash.add(&size, sizeof size);
  hash.add(values.data(), values.size() * sizeof(T));
}

void addParameters(Hash& hash, const std::vector<ParsedParameter>& parameters, const MemoryFiles* files) {
  for (const ParsedParameter& p : parameters) {
    hash.add(p.type);
    hash.add(p.name);
    hash.add(p.directory);
    addValues(hash, p.numbers);
    for (const bool b : p.booleans) hash.add(b ? "true" : "false");
    for (const std::string& s : p.strings) {
      hash.add(s);
      if (!files) continue;
      if (const auto found = files->find(s); found != files->end()) hash.add(*found->second);
    }
  }
}

void addDirective(Hash& hash, const ParsedDirective& d) {
  hash.add(d.type);
  hash.add(d.directory);
  hash.add(d.topDirectory);
  addParameters(hash, d.parameters, d.files.get());
  hash.add("attributes");
  if (d.attributes) addParameters(hash, *d.attributes, d.files.get());
}

} // namespace

std::string keyOf(const ParsedDirective& directive) {
  Hash hash;
  addDirective(hash, directive);
  return hash.text();
}

std::string keyOf(const ParsedDirective& directive, const Mat4d& place) {
  Hash hash;
  addDirective(hash, directive);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) hash.add(&place[c][r], sizeof(double));
  return hash.text();
}

} // namespace recurse
