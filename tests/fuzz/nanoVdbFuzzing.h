/** @file
 * NanoVDB files from a fuzzer's bytes: a valid file is too large to be found at random, so the bytes are
 * changes of one.
 */
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "model/nanoVdbTesting.h"

namespace recurse {

inline const std::string& goodNanoVdb() {
  static const std::string FILE = [] {
    testing::WrittenGrid density, heat;
    density(1, 2, 3) = 4;
    density(130, -5, 9) = 2;
    heat.name = "temperature";
    heat(1, 2, 3) = 900;
    return testing::NanoVdbWriter::file({density, heat});
  }();
  return FILE;
}

/** Relevant bytes of the good file: all but the tables of inner nodes, which are nearly empty. */
inline const std::vector<size_t>& tellingPlaces() {
  static const std::vector<size_t> PLACES = [] {
    std::vector<size_t> list;
    for (size_t i = 0; i < goodNanoVdb().size(); ++i)
      if (i < 1200 || goodNanoVdb()[i] != 0) list.push_back(i);
    return list;
  }();
  return PLACES;
}

/** The good file with one change for every twelve bytes; remaining bytes truncate it. */
inline std::string changedNanoVdb(const uint8_t* data, size_t size) {
  std::string bytes = goodNanoVdb();
  struct Change {
    uint16_t place;
    uint8_t width;
    uint64_t value;
  };
  for (; size >= 12; data += 12, size -= 12) {
    Change c;
    std::memcpy(&c.place, data, 2);
    std::memcpy(&c.width, data + 2, 1);
    std::memcpy(&c.value, data + 4, 8);
    const size_t at = tellingPlaces()[c.place % tellingPlaces().size()], width = size_t(1) << c.width % 4;
    if (at + width <= bytes.size()) std::memcpy(&bytes[at], &c.value, width);
  }
  if (size >= 3) bytes.resize(bytes.size() * data[0] / 255);
  return bytes;
}

} // namespace recurse
