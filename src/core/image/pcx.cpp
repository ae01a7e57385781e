/** @file
 * Decoding of PCX (ZSoft, "PCX Technical Reference Manual", 1991): a header of 128 bytes, run lengths, and a
 * palette at the end.
 */
#include "core/image/pcx.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "recurse/core/io/error.h"
#include "recurse/core/threads/resources.h"

namespace recurse::detail {

namespace {

constexpr size_t HEADER_BYTES = 128, PALETTE_BYTES = 1 + 3 * 256;
constexpr uint8_t PALETTE_MARK = 0x0c;

class PcxReader {
 public:
  PcxReader(const std::string& fileName, const std::string& bytes) : fileName(fileName), bytes(bytes) {
    if (bytes.size() < HEADER_BYTES || byte(0) != 0x0a) fail("this is no PCX file");
    if (byte(2) != 1 || byte(3) != 8 || (planes() != 1 && planes() != 3))
      fail("only PCX of 8 bits with a palette or of 24 bits can be read");
    const int right = word(8), bottom = word(10);
    width = right - word(4) + 1;
    height = bottom - word(6) + 1;
    if (width < 1 || height < 1) fail("its corners are in the wrong order");
    lineBytes = size_t(word(66));
    if (lineBytes < size_t(width)) fail("its lines are shorter than its width");
    end = bytes.size();
    if (planes() == 1) {
      if (bytes.size() < HEADER_BYTES + PALETTE_BYTES || byte(bytes.size() - PALETTE_BYTES) != PALETTE_MARK)
        fail("the palette at its end is missing");
      end -= PALETTE_BYTES;
    }
    // A run of two bytes encodes at most 63 values.
    if (double(height) * double(lineBytes * planes()) > 63.0 / 2 * double(end - HEADER_BYTES) + 1)
      fail("it is too short for its size");
    requireMemory(fileName, 4.0 * double(width) * double(height));
  }

  std::string tga() {
    std::string out(18, '\0');
    out[2] = 2; // true colour, not compressed
    const auto put = [&out](size_t place, int value) {
      out[place] = static_cast<char>(value & 255);
      out[place + 1] = static_cast<char>(value >> 8);
    };
    put(12, width);
    put(14, height);
    out[16] = 24;
    out[17] = 0x20; // rows from the top
    std::vector<uint8_t> line(lineBytes * planes());
    const size_t palette = bytes.size() - PALETTE_BYTES + 1;
    for (int y = 0; y < height; ++y) {
      for (uint8_t& value : line) value = nextValue();
      for (size_t x = 0; x < size_t(width); ++x)
        for (size_t c = 3; c-- > 0;) // blue, green, red
          out += static_cast<char>(planes() == 3 ? line[c * lineBytes + x] : byte(palette + 3 * line[x] + c));
    }
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(fileName + ": cannot be read: " + what);
  }
  uint8_t byte(size_t i) const { return static_cast<uint8_t>(bytes[i]); }
  int word(size_t i) const { return byte(i) | byte(i + 1) << 8; }
  size_t planes() const { return byte(65); }

  uint8_t nextValue() {
    while (run == 0) { // runs of length 0 encode nothing
      value = take();
      run = 1;
      if (value < 0xc0) break;
      run = value & 63u;
      value = take();
    }
    --run;
    return value;
  }
  uint8_t take() {
    if (at == end) fail("the file ends before the picture is complete");
    return byte(at++);
  }

  const std::string& fileName;
  const std::string& bytes;
  int width = 0, height = 0;
  size_t lineBytes = 0, at = HEADER_BYTES, end = 0;
  uint32_t run = 0;
  uint8_t value = 0;
};

} // namespace

std::string tgaOfPcx(const std::string& fileName, const std::string& pcx) {
  return PcxReader(fileName, pcx).tga();
}

} // namespace recurse::detail
