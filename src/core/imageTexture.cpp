/** @file
 * Pictures as textures. A file is read once, and kept in the type that it has; OpenImageIO's cache asks for
 * its rows through an ImageInput of our own, which decodes them, so that filtering is done in linear light.
 */
#include "recurse/core/imageTexture.h"

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

#include "core/imageInput.h"
#include "recurse/core/error.h"
#include "recurse/core/image.h"

namespace recurse {

namespace {

constexpr const char* PIXELS = "recurse:pixels";

/** The pixels of a file: one channel or three. */
struct Pixels {
  int width = 0, height = 0, channels = 0;
  OIIO::TypeDesc type; ///< UINT8, UINT16, HALF or FLOAT
  std::vector<std::byte> bytes;
  ImageEncoding encoding;

  size_t rowValues() const { return size_t(width) * size_t(channels); }
  size_t rowBytes() const { return rowValues() * type.size(); }
  bool coded() const { return !type.is_floating_point() && encoding.kind != ImageEncoding::Kind::LINEAR; }
  /** Halves have more digits than eight bits. */
  OIIO::TypeDesc decodedType() const {
    if (!coded()) return type;
    return type == OIIO::TypeDesc::UINT8 ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT;
  }
  float decode(float value) const {
    return encoding.kind == ImageEncoding::Kind::SRGB ? linearFromSrgb(value)
                                                      : std::pow(value, encoding.gamma);
  }
};

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

Pixels readPixels(const std::string& fileName, const ImageEncoding& encoding) {
  const std::unique_ptr<OIIO::ImageInput> input = detail::openImage(fileName);
  const OIIO::ImageSpec& spec = input->spec();
  const std::vector<int> order = channelOrder(fileName, spec.channelnames);
  Pixels p;
  p.width = spec.width;
  p.height = spec.height;
  p.channels = order[0] == order[1] ? 1 : 3;
  p.encoding = encoding;
  p.type = spec.format;
  const auto kept = {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::UINT16, OIIO::TypeDesc::HALF};
  if (std::none_of(kept.begin(), kept.end(), [&](auto t) { return p.type == t; })) {
    // Integers of other widths are scaled to [0, 1] on the way, and stay coded.
    p.type = p.type.is_floating_point() ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT16;
  }
  const size_t stored = size_t(spec.nchannels), each = p.type.size(),
               count = size_t(p.width) * size_t(p.height);
  std::vector<std::byte> all(count * stored * each);
  if (!input->read_image(0, 0, 0, spec.nchannels, p.type, all.data()))
    throw Error(fileName + ": cannot be read: " + input->geterror());
  if (p.channels == spec.nchannels && order[0] == 0 && order[size_t(p.channels) - 1] == p.channels - 1) {
    p.bytes = std::move(all);
  } else {
    p.bytes.resize(count * size_t(p.channels) * each);
    for (size_t i = 0; i < count; ++i)
      for (size_t c = 0; c < size_t(p.channels); ++c)
        std::memcpy(&p.bytes[(i * size_t(p.channels) + c) * each],
                    &all[(i * stored + size_t(order[c])) * each], each);
  }
  if (p.type.is_floating_point()) refuseNonFinite(fileName, p);
  return p;
}

/** What OpenImageIO's cache reads from in the place of a file. */
class DecodedInput final : public OIIO::ImageInput {
 public:
  const char* format_name() const override { return "recurse"; }
  bool open(const std::string&, OIIO::ImageSpec&) override { return false; }
  bool open(const std::string&, OIIO::ImageSpec& newSpec, const OIIO::ImageSpec& config) override {
    const OIIO::ParamValue* attribute = config.find_attribute(PIXELS, OIIO::TypeDesc::PTR);
    if (!attribute) return false;
    pixels = static_cast<const Pixels*>(*static_cast<void* const*>(attribute->data()));
    m_spec = OIIO::ImageSpec(pixels->width, pixels->height, pixels->channels, pixels->decodedType());
    newSpec = m_spec;
    if (pixels->coded()) {
      const size_t codes = pixels->type == OIIO::TypeDesc::UINT8 ? 256 : 65536;
      for (size_t i = 0; i < codes; ++i)
        table.push_back(pixels->decode(static_cast<float>(i) / static_cast<float>(codes - 1)));
    }
    return true;
  }
  bool close() override { return true; }
  bool read_native_scanline(int subimage, int level, int y, int, void* data) override {
    if (subimage != 0 || level != 0) return false;
    const std::byte* row = pixels->bytes.data() + size_t(y) * pixels->rowBytes();
    if (table.empty()) {
      std::memcpy(data, row, pixels->rowBytes());
      return true;
    }
    const size_t count = pixels->rowValues();
    std::vector<float> linear(count);
    for (size_t i = 0; i < count; ++i) {
      uint16_t code = 0;
      if (pixels->type == OIIO::TypeDesc::UINT8)
        code = static_cast<uint16_t>(row[i]);
      else
        std::memcpy(&code, row + i * sizeof code, sizeof code);
      linear[i] = table[code];
    }
    return OIIO::convert_types(OIIO::TypeDesc::FLOAT, linear.data(), m_spec.format, data,
                               static_cast<int>(count));
  }

 private:
  const Pixels* pixels = nullptr;
  std::vector<float> table; ///< of codes; empty where values are linear
};

/** OpenImageIO's texture system, which lives as long as a texture does. */
class TextureCache {
 public:
  TextureCache() : tiles(OIIO::ImageCache::create(false)), system(OIIO::TextureSystem::create(false, tiles)) {
    tiles->attribute("automip", 1);
    tiles->attribute("autotile", 64);
    tiles->attribute("max_memory_MB", 1024.0f);
    system->attribute("gray_to_rgb", 1);
  }
  ~TextureCache() {
    OIIO::TextureSystem::destroy(system);
    OIIO::ImageCache::destroy(tiles);
  }
  TextureCache(const TextureCache&) = delete;
  TextureCache& operator=(const TextureCache&) = delete;

  static std::shared_ptr<TextureCache> common() {
    static std::mutex one;
    static std::weak_ptr<TextureCache> current;
    const std::lock_guard<std::mutex> guard(one);
    std::shared_ptr<TextureCache> cache = current.lock();
    if (!cache) current = cache = std::make_shared<TextureCache>();
    return cache;
  }

  OIIO::ImageCache* const tiles;
  OIIO::TextureSystem* const system;
};

} // namespace

struct ImageTexture::Source {
  std::shared_ptr<TextureCache> cache;
  Pixels pixels;
  OIIO::ustring name;
  OIIO::TextureSystem::TextureHandle* handle = nullptr;

  Source(const std::string& fileName, const ImageEncoding& encoding)
      : cache(TextureCache::common()), pixels(readPixels(fileName, encoding)) {
    static std::atomic<uint64_t> number{0};
    name = OIIO::ustring(std::to_string(++number) + ":" + fileName);
    OIIO::ImageSpec config;
    const void* pointer = &pixels;
    config.attribute(PIXELS, OIIO::TypeDesc::PTR, &pointer);
    const OIIO::ImageInput::Creator creator = []() -> OIIO::ImageInput* { return new DecodedInput; };
    if (cache->tiles->add_file(name, creator, &config)) handle = cache->system->get_texture_handle(name);
    if (!handle || !cache->system->good(handle))
      throw Error(fileName + ": cannot be used as a texture: " + cache->tiles->geterror());
  }
  ~Source() { cache->tiles->invalidate(name); }
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  /** The one of this file and encoding, while anything uses it. */
  static std::shared_ptr<const Source> of(const std::string& fileName, const ImageEncoding& encoding) {
    using Key = std::tuple<std::string, int, float>;
    static std::mutex one;
    static std::map<Key, std::weak_ptr<const Source>> known;
    const std::lock_guard<std::mutex> guard(one);
    std::weak_ptr<const Source>& place = known[{fileName, static_cast<int>(encoding.kind), encoding.gamma}];
    std::shared_ptr<const Source> source = place.lock();
    if (!source) place = source = std::make_shared<const Source>(fileName, encoding);
    return source;
  }
};

ImageTexture::ImageTexture(const std::string& fileName, const ImageEncoding& encoding,
                           const ImageTextureSettings& settings)
    : source(Source::of(fileName, encoding)), settings(settings) {}

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
  options.anisotropic = std::max(1, static_cast<int>(settings.mostAnisotropy));
  options.swrap = options.twrap = settings.wrap == Wrap::REPEAT  ? OIIO::TextureOpt::WrapPeriodic
                                  : settings.wrap == Wrap::BLACK ? OIIO::TextureOpt::WrapBlack
                                                                 : OIIO::TextureOpt::WrapClamp;
  if (settings.wrap == Wrap::OCTAHEDRAL) {
    // Over an edge of the square the sphere goes on at the mirror image of the place on the same edge.
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
  if (!source->cache->system->texture(source->handle, nullptr, options, st.x, st.y, alongX.x, alongX.y,
                                      alongY.x, alongY.y, 3, &result.x))
    throw Error(source->name.string() + ": " + source->cache->system->geterror());
  return result;
}

} // namespace recurse
