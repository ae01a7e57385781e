/** @file
 * Image textures. A file is read once and kept in its own type. OpenImageIO's cache requests its rows through
 * an ImageInput of Recurse, which decodes them, so that filtering is done in linear light.
 */
#include "recurse/core/image/imageTexture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <tuple>
#include <vector>

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/texture.h>

#include "core/image/imageInput.h"
#include "core/image/pixelStore.h"
#include "recurse/core/image/image.h"
#include "recurse/core/io/error.h"

namespace recurse {

namespace {

constexpr const char* PIXELS = "recurse:pixels";

/** The pixels of a file: one channel or three. */
struct Pixels {
  int width = 0, height = 0, channels = 0;
  OIIO::TypeDesc type; ///< UINT8, UINT16, HALF or FLOAT
  detail::PixelStore bytes;
  ImageEncoding encoding;

  size_t rowValues() const { return size_t(width) * size_t(channels); }
  size_t rowBytes() const { return rowValues() * type.size(); }
  bool coded() const { return !type.is_floating_point() && encoding.kind != ImageEncoding::Kind::LINEAR; }
  /** Type of decoded pixels: half floats have more digits than 8-bit codes; 16-bit codes need floats. */
  OIIO::TypeDesc decodedType() const {
    if (!coded()) return type;
    return type == OIIO::TypeDesc::UINT8 ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT;
  }
  float decode(float value) const {
    return encoding.kind == ImageEncoding::Kind::SRGB ? linearFromSrgb(value)
                                                      : std::pow(value, encoding.gamma);
  }
};

/** Indices of the red, green and blue channels of the file; the same index three times for grey. */
std::vector<int> channelsOf(const std::string& fileName, const OIIO::ImageSpec& spec,
                            ImageChannels channels) {
  if (channels == ImageChannels::ALPHA) {
    const int alpha = detail::alphaChannel(spec);
    if (alpha < 0) throw Error(fileName + ": has no alpha channel");
    return std::vector<int>(3, alpha);
  }
  const std::vector<int> order = channelOrder(fileName, spec.channelnames);
  if (channels == ImageChannels::COLOURS) return order;
  return std::vector<int>(3, order[static_cast<size_t>(channels) - static_cast<size_t>(ImageChannels::RED)]);
}

void refuseNonFinite(const std::string& fileName, const Pixels& p) {
  std::vector<float> row(p.rowValues());
  for (int y = 0; y < p.height; ++y) {
    OIIO::convert_types(p.type, p.bytes.data() + size_t(y) * p.rowBytes(), OIIO::TypeDesc::FLOAT, row.data(),
                        static_cast<int>(row.size()));
    for (size_t i = 0; i < row.size(); ++i)
      if (!std::isfinite(row[i]))
        throw Error(fileName + ": the pixel at column " + std::to_string(i / size_t(p.channels)) + ", row " +
                    std::to_string(y) + " is not finite");
  }
}

Pixels readPixels(const FileReference& file, const ImageEncoding& encoding, ImageChannels channels) try {
  const std::string& fileName = file.path;
  const detail::OpenImage input = detail::openImage(file);
  const OIIO::ImageSpec& spec = input->spec();
  const std::vector<int> order = channelsOf(fileName, spec, channels);
  Pixels p;
  p.width = spec.width;
  p.height = spec.height;
  p.channels = order[0] == order[1] ? 1 : 3;
  p.encoding = encoding;
  p.type = spec.format;
  const auto kept = {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16, OIIO::TypeDesc::HALF};
  if (std::none_of(kept.begin(), kept.end(), [&](auto t) { return p.type == t; })) {
    // Integers of other widths are scaled to 16 bits, and stay encoded.
    p.type = p.type.is_floating_point() ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT16;
  }
  const size_t stored = size_t(spec.nchannels), each = p.type.size(),
               count = size_t(p.width) * size_t(p.height);
  std::vector<std::byte> all(count * stored * each);
  if (!input->read_image(0, 0, 0, spec.nchannels, p.type, all.data()))
    throw Error(fileName + ": cannot be read: " + detail::readFailure(input.input->geterror()));
  if (p.channels == spec.nchannels && order[0] == 0 && order[size_t(p.channels) - 1] == p.channels - 1) {
    p.bytes = detail::PixelStore(std::move(all));
  } else {
    std::vector<std::byte> chosen(count * size_t(p.channels) * each);
    for (size_t i = 0; i < count; ++i)
      for (size_t c = 0; c < size_t(p.channels); ++c)
        std::memcpy(&chosen[(i * size_t(p.channels) + c) * each],
                    &all[(i * stored + size_t(order[c])) * each], each);
    p.bytes = detail::PixelStore(std::move(chosen));
  }
  if (p.type.is_floating_point()) refuseNonFinite(fileName, p);
  return p;
} catch (const std::bad_alloc&) {
  throw detail::lacksMemory(file);
}

/** A coarser level of detail: linear light, in Pixels::decodedType(). */
struct Level {
  int width = 0, height = 0;
  detail::PixelStore bytes;
};

/** Mipmap of the pixels: level 0 is decoded on request, and the coarser levels are all made at first use. */
class Pyramid {
 public:
  explicit Pyramid(const Pixels& pixels) : pixels(pixels) {}
  int count() const {
    int n = 1;
    for (int w = pixels.width, h = pixels.height; w > 1 || h > 1; ++n) {
      w = half(w);
      h = half(h);
    }
    return n;
  }
  int channels() const { return pixels.channels; }
  OIIO::TypeDesc type() const { return pixels.decodedType(); }
  int width(int level) const { return level == 0 ? pixels.width : half(width(level - 1)); }
  int height(int level) const { return level == 0 ? pixels.height : half(height(level - 1)); }

  void readRow(int level, int y, void* into) {
    if (level == 0) {
      std::vector<float> linear(pixels.rowValues());
      decodeRow(y, linear.data());
      encode(linear, into);
      return;
    }
    std::call_once(made, [&] { make(); });
    const Level& l = levels[size_t(level) - 1];
    const size_t bytes = size_t(l.width) * size_t(pixels.channels) * pixels.decodedType().size();
    std::memcpy(into, l.bytes.data() + size_t(y) * bytes, bytes);
  }

 private:
  static int half(int n) { return std::max(1, n / 2); }

  void decodeRow(int y, float* linear) {
    const std::byte* row = pixels.bytes.data() + size_t(y) * pixels.rowBytes();
    const size_t n = pixels.rowValues();
    if (!pixels.coded()) {
      OIIO::convert_types(pixels.type, row, OIIO::TypeDesc::FLOAT, linear, static_cast<int>(n));
      return;
    }
    std::call_once(tableMade, [&] {
      const size_t codes = pixels.type == OIIO::TypeDesc::UINT8 ? 256 : 65536;
      for (size_t i = 0; i < codes; ++i)
        table.push_back(pixels.decode(static_cast<float>(i) / static_cast<float>(codes - 1)));
    });
    for (size_t i = 0; i < n; ++i) {
      uint16_t code = 0;
      if (pixels.type == OIIO::TypeDesc::UINT8)
        code = static_cast<uint16_t>(row[i]);
      else
        std::memcpy(&code, row + i * sizeof code, sizeof code);
      linear[i] = table[code];
    }
  }
  void encode(const std::vector<float>& linear, void* into) const {
    OIIO::convert_types(OIIO::TypeDesc::FLOAT, linear.data(), pixels.decodedType(), into,
                        static_cast<int>(linear.size()));
  }

  /** Makes the coarser levels: each pixel is the mean of the area that it covers in the level before. */
  void make() {
    const auto channels = size_t(pixels.channels);
    std::vector<float> above;
    for (int level = 1; level < count(); ++level) {
      const int w0 = width(level - 1), h0 = height(level - 1), w = width(level), h = height(level);
      std::vector<float> now(size_t(w) * size_t(h) * channels), row(size_t(w0) * channels);
      for (int y0 = 0; y0 < h0; ++y0) {
        const float* from = level == 1 ? row.data() : &above[size_t(y0) * row.size()];
        if (level == 1) decodeRow(y0, row.data());
        forShares(y0, h0, h, [&](int y, float partY) {
          float* into = &now[size_t(y) * size_t(w) * channels];
          for (int x0 = 0; x0 < w0; ++x0)
            forShares(x0, w0, w, [&](int x, float partX) {
              for (size_t c = 0; c < channels; ++c)
                into[size_t(x) * channels + c] += partX * partY * from[size_t(x0) * channels + c];
            });
        });
      }
      std::vector<std::byte> bytes(now.size() * pixels.decodedType().size());
      encode(now, bytes.data());
      levels.push_back({w, h, detail::PixelStore(std::move(bytes))});
      above = std::move(now);
      if (level == 1) pixels.bytes.rest();
    }
  }
  /** Calls use(to, fraction) for the one or two of `count` pixels that overlap pixel `from` of `all`. */
  template <class Use> static void forShares(int from, int all, int count, const Use& use) {
    if (all == 2 * count) return use(from / 2, 0.5f);
    const double scale = double(count) / double(all), begin = from * scale, end = (from + 1) * scale;
    const int first = std::min(static_cast<int>(begin), count - 1);
    const double inFirst = std::min(end, first + 1.0) - begin;
    use(first, static_cast<float>(inFirst));
    if (first + 1 < count && end > first + 1) use(first + 1, static_cast<float>(end - (first + 1)));
  }

  const Pixels& pixels;
  std::once_flag made, tableMade;
  std::vector<float> table; ///< linear value of each code
  std::vector<Level> levels;
};

/** Input of OpenImageIO's cache that reads from a Pyramid instead of a file. */
class DecodedInput final : public OIIO::ImageInput {
 public:
  const char* format_name() const override { return "recurse"; }
  bool open(const std::string&, OIIO::ImageSpec&) override { return false; }
  bool open(const std::string&, OIIO::ImageSpec& newSpec, const OIIO::ImageSpec& config) override {
    const OIIO::ParamValue* attribute = config.find_attribute(PIXELS, OIIO::TypeDesc::PTR);
    if (!attribute) return false;
    pyramid = static_cast<Pyramid*>(*static_cast<void* const*>(attribute->data()));
    return seek_subimage(0, 0) && (newSpec = m_spec, true);
  }
  bool close() override { return true; }
  int current_miplevel() const override { return level; }
  bool seek_subimage(int subimage, int newLevel) override {
    if (subimage != 0 || newLevel < 0 || newLevel >= pyramid->count()) return false;
    level = newLevel;
    m_spec =
        OIIO::ImageSpec(pyramid->width(level), pyramid->height(level), pyramid->channels(), pyramid->type());
    return true;
  }
  bool read_native_scanline(int subimage, int ofLevel, int y, int, void* data) override {
    if (subimage != 0 || ofLevel < 0 || ofLevel >= pyramid->count()) return false;
    pyramid->readRow(ofLevel, y, data);
    return true;
  }

 private:
  Pyramid* pyramid = nullptr;
  int level = 0;
};

/** Memory of tiles in OpenImageIO's cache [bytes]. */
double cacheBytes = 0x1p30;

/** OpenImageIO's texture system. It is never destroyed, since threads that used it and end later still access
 * their data in it. */
class TextureCache {
 public:
  TextureCache(const TextureCache&) = delete;
  TextureCache& operator=(const TextureCache&) = delete;

  static TextureCache& common() {
    static TextureCache* const cache = new TextureCache;
    cache->tiles->attribute("max_memory_MB", static_cast<float>(cacheBytes / 0x1p20));
    return *cache;
  }

  OIIO::ImageCache* const tiles;
  OIIO::TextureSystem* const system;

 private:
  TextureCache() : tiles(OIIO::ImageCache::create(false)), system(OIIO::TextureSystem::create(false, tiles)) {
    tiles->attribute("autotile", 64);
    system->attribute("gray_to_rgb", 1);
  }
};

} // namespace

struct ImageTexture::Source {
  TextureCache& cache = TextureCache::common();
  Pixels pixels;
  Pyramid pyramid;
  OIIO::ustring name;
  OIIO::TextureSystem::TextureHandle* handle = nullptr;
  std::shared_ptr<const std::string> content; ///< kept alive, since its address is a part of the key

  Source(const FileReference& file, const ImageEncoding& encoding, ImageChannels channels)
      : pixels(readPixels(file, encoding, channels)), pyramid(pixels) {
    const std::string& fileName = file.path;
    static std::atomic<uint64_t> number{0};
    content = file.content;
    name = OIIO::ustring(std::to_string(++number) + ":" + fileName);
    OIIO::ImageSpec config;
    const void* pointer = &pyramid;
    config.attribute(PIXELS, OIIO::TypeDesc::PTR, &pointer);
    const OIIO::ImageInput::Creator creator = []() -> OIIO::ImageInput* { return new DecodedInput; };
    if (cache.tiles->add_file(name, creator, &config)) handle = cache.system->get_texture_handle(name);
    if (!handle || !cache.system->good(handle))
      throw Error(fileName + ": cannot be used as a texture: " + cache.tiles->geterror());
  }
  ~Source() { cache.tiles->invalidate(name); }
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  /** Shared source of this file, these channels and this encoding, as long as any texture uses it. */
  static std::shared_ptr<const Source> of(const FileReference& file, const ImageEncoding& encoding,
                                          ImageChannels channels) {
    using Key = std::tuple<std::string, const void*, ImageChannels, ImageEncoding::Kind, float>;
    static std::mutex one;
    static std::map<Key, std::weak_ptr<const Source>> known;
    const std::lock_guard<std::mutex> guard(one);
    std::weak_ptr<const Source>& place =
        known[{file.path, file.content.get(), channels, encoding.kind, encoding.gamma}];
    std::shared_ptr<const Source> source = place.lock();
    if (!source) place = source = std::make_shared<const Source>(file, encoding, channels);
    return source;
  }
};

void setTextureMemory(double bytes) {
  cacheBytes = std::max(bytes / 2, 0x1p24); // with less, tiles would be evicted all the time
  detail::PixelStore::setLimit(bytes - cacheBytes);
}

std::pair<size_t, size_t> textureMemory() { return detail::PixelStore::totals(); }

ImageTexture::ImageTexture(const FileReference& file, const ImageEncoding& encoding,
                           const ImageTextureSettings& settings)
    : source(Source::of(file,
                        settings.channels == ImageChannels::ALPHA
                            ? ImageEncoding{ImageEncoding::Kind::LINEAR, 1}
                            : encoding,
                        settings.channels)),
      settings(settings) {}

ImageTexture::~ImageTexture() = default;

int ImageTexture::width() const { return source->pixels.width; }
int ImageTexture::height() const { return source->pixels.height; }

Rgb ImageTexture::at(Vec2f st, const Vec2f& alongX, const Vec2f& alongY) const {
  using Filter = ImageTextureSettings::Filter;
  using Wrap = ImageTextureSettings::Wrap;
  OIIO::TextureOpt options;
  options.interpmode =
      settings.filter == Filter::POINT ? OIIO::TextureOpt::InterpClosest : OIIO::TextureOpt::InterpBilinear;
  options.mipmode = !settings.levels                       ? OIIO::TextureOpt::MipModeNoMIP
                    : settings.filter == Filter::EWA       ? OIIO::TextureOpt::MipModeAniso
                    : settings.filter == Filter::TRILINEAR ? OIIO::TextureOpt::MipModeTrilinear
                                                           : OIIO::TextureOpt::MipModeOneLevel;
  options.anisotropic = std::max(1, static_cast<int>(settings.maxAnisotropy));
  options.swrap = options.twrap = settings.wrap == Wrap::REPEAT  ? OIIO::TextureOpt::WrapPeriodic
                                  : settings.wrap == Wrap::BLACK ? OIIO::TextureOpt::WrapBlack
                                                                 : OIIO::TextureOpt::WrapClamp;
  if (settings.wrap == Wrap::OCTAHEDRAL) {
    // Beyond an edge of the square, the sphere continues at the mirror image of the point on the same edge.
    const auto fold = [](float& x, float& y) {
      x -= 2 * std::floor(x / 2);
      if (x <= 1) return;
      x = 2 - x;
      y = 1 - y;
    };
    fold(st.x, st.y);
    fold(st.y, st.x);
    fold(st.x, st.y);
  }
  Rgb result(0);
  if (!source->cache.system->texture(source->handle, nullptr, options, st.x, st.y, alongX.x, alongX.y,
                                     alongY.x, alongY.y, 3, &result.r))
    throw Error(source->name.string() + ": " + source->cache.system->geterror());
  return result;
}

} // namespace recurse
