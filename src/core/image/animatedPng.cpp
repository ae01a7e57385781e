/** @file
 * Animated PNG: the chunks of PNG files in new wrappings.
 */
#include "recurse/core/image/animationFile.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "recurse/core/io/error.h"

namespace recurse {

namespace {

using Bytes = std::vector<unsigned char>;

constexpr size_t SIGNATURE = 8; ///< bytes before the first chunk

/** CRC-32 of PNG chunks (PNG specification, annex D). */
uint32_t crc32Of(const unsigned char* bytes, size_t count) {
  static const std::array<uint32_t, 256> TABLE = [] {
    std::array<uint32_t, 256> table{};
    for (uint32_t n = 0; n < table.size(); ++n) {
      uint32_t c = n;
      for (int bit = 0; bit < 8; ++bit) c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
      table[n] = c;
    }
    return table;
  }();
  uint32_t crc = 0xffffffffu;
  for (size_t i = 0; i < count; ++i) crc = TABLE[(crc ^ bytes[i]) & 0xff] ^ (crc >> 8);
  return ~crc;
}

void append32(Bytes& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<unsigned char>(value >> shift));
}

void append16(Bytes& out, uint32_t value) {
  out.push_back(static_cast<unsigned char>(value >> 8));
  out.push_back(static_cast<unsigned char>(value));
}

uint32_t read32(const unsigned char* p) {
  return uint32_t(p[0]) << 24 | uint32_t(p[1]) << 16 | uint32_t(p[2]) << 8 | uint32_t(p[3]);
}

struct Chunk {
  std::string_view type;
  Bytes data;
};

void appendChunk(Bytes& out, const Chunk& chunk) {
  append32(out, static_cast<uint32_t>(chunk.data.size()));
  const size_t begin = out.size();
  out.insert(out.end(), chunk.type.begin(), chunk.type.end());
  out.insert(out.end(), chunk.data.begin(), chunk.data.end());
  append32(out, crc32Of(out.data() + begin, out.size() - begin));
}

/** Calls visit(chunk) for each chunk of a PNG file. */
template <class Visit> void forEachChunk(const Bytes& png, const Visit& visit) {
  constexpr size_t AROUND = 12; // length, type and checksum
  for (size_t at = SIGNATURE; at + AROUND <= png.size();) {
    const size_t length = read32(&png[at]);
    if (length > png.size() - at - AROUND) throw Error("a frame of the film is not a PNG");
    const auto* type = reinterpret_cast<const char*>(&png[at + 4]);
    const auto data = png.begin() + static_cast<std::ptrdiff_t>(at + 8);
    visit(Chunk{{type, 4}, Bytes(data, data + static_cast<std::ptrdiff_t>(length))});
    at += length + AROUND;
  }
}

/** Frame control chunk: a full frame of the header's size, for the duration of a frame. */
Chunk frameControl(uint32_t sequence, const Bytes& header, double framesPerSecond) {
  Chunk out{"fcTL", {}};
  append32(out.data, sequence);
  out.data.insert(out.data.end(), header.begin(), header.begin() + 8); // width and height
  for (int i = 0; i < 2; ++i) append32(out.data, 0);                   // offset
  const bool isWhole = framesPerSecond == std::floor(framesPerSecond);
  append16(out.data, isWhole ? 1 : 100);
  append16(out.data, static_cast<uint32_t>(std::lround(framesPerSecond * (isWhole ? 1 : 100))));
  append16(out.data, 0); // no disposal, no blending
  return out;
}

} // namespace

std::vector<unsigned char> animatedPng(const std::vector<std::vector<unsigned char>>& frames,
                                       double framesPerSecond) {
  if (frames.empty()) throw Error("a film has at least one frame");
  Bytes out(frames[0].begin(), frames[0].begin() + SIGNATURE), header;
  uint32_t sequence = 0;
  for (const Bytes& frame : frames) {
    const bool isFirst = &frame == frames.data();
    bool isBegun = false;
    forEachChunk(frame, [&](Chunk chunk) {
      if (chunk.type == "IDAT") {
        if (!isBegun) appendChunk(out, frameControl(sequence++, header, framesPerSecond));
        isBegun = true;
        if (!isFirst) {
          Bytes numbered;
          append32(numbered, sequence++);
          numbered.insert(numbered.end(), chunk.data.begin(), chunk.data.end());
          chunk = {"fdAT", std::move(numbered)};
        }
        appendChunk(out, chunk);
      } else if (chunk.type == "IHDR" && !isFirst) {
        if (chunk.data != header) throw Error("the frames of a film have different sizes");
      } else if (isFirst && chunk.type != "IEND") {
        appendChunk(out, chunk);
        if (chunk.type != "IHDR") return;
        header = chunk.data;
        Chunk control{"acTL", {}};
        append32(control.data, static_cast<uint32_t>(frames.size()));
        append32(control.data, 0); // repeated without end
        appendChunk(out, control);
      }
    });
  }
  appendChunk(out, {"IEND", {}});
  return out;
}

} // namespace recurse
