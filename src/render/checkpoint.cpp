/** @file
 * Checkpoint files: a magic line, a header in JSON, the state of the film and of the allocation of adaptive
 * samples, and a checksum.
 */
#include "recurse/render/checkpoint.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include <nlohmann/json.hpp>
#include <zlib.h>

#include "recurse/core/io/atomicFile.h"
#include "recurse/core/io/error.h"
#include "recurse/core/io/files.h"

namespace recurse {

namespace {

using Json = nlohmann::ordered_json;
static_assert(std::endian::native == std::endian::little, "checkpoints are not turned around");

const std::string MAGIC = "Recurse checkpoint 10\n";
/** Size of a header [bytes], above which the file is damaged. */
constexpr uint64_t MAX_HEADER = 1 << 24;

uint64_t checksum(uint64_t state, std::span<const std::byte> bytes) {
  return ::crc32_z(state, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
}

/** State after the header: the film's numbers, then the allocation's, if there is one. */
std::vector<std::span<std::byte>> numbersOf(Checkpoint& c) {
  std::vector<std::span<std::byte>> out;
  for (const std::span<std::byte> part : c.film.state()) out.push_back(part);
  if (c.allocation)
    for (const std::span<std::byte> part : c.allocation->state()) out.push_back(part);
  return out;
}

/** Calls `use(name, value)` for each figure of a position that is kept. */
template <class Position, class Use> void forEachFigure(Position& p, const Use& use) {
  auto& s = p.statistics;
  use("sample", p.sample);
  use("render_seconds", s.renderSeconds);
  use("processor_seconds", s.processorSeconds);
  use("learning_processor_seconds", s.learningProcessorSeconds);
  use("photon_processor_seconds", s.photonProcessorSeconds);
  use("photon_seconds", s.photonSeconds);
  use("balance_seconds", s.balanceSeconds);
  use("photons_emitted", s.photonsEmitted);
  use("photons_stored", s.photonsStored);
  use("photons_refused", s.photonsRefused);
  use("map_bytes", s.mapBytes);
  use("rays", s.counts.rays);
  use("boundary_rays", s.counts.boundaryRays);
  use("non_finite", s.counts.nonFinite);
  use("weight_cut", s.counts.truncatedThroughput);
  use("gathers", s.counts.gathers);
  use("photons_found", s.counts.photonsFound);
  use("photons_scattered", s.counts.photonsScattered);
  use("caustic_radii", s.counts.causticRadii.bins);
  use("caustic_radii_log2", s.counts.causticRadii.sumLog2);
  use("other_radii", s.counts.otherRadii.bins);
  use("other_radii_log2", s.counts.otherRadii.sumLog2);
  use("passes", s.passes);
  use("photon_maps", s.forwardPasses);
}

Json toJson(const RenderPosition& p) {
  Json j;
  forEachFigure(p, [&](const char* name, const auto& value) { j[name] = value; });
  return j;
}

Json toJson(const std::optional<std::vector<WorkUnit>>& left) {
  if (!left) return nullptr;
  Json out = Json::array();
  for (const WorkUnit& u : *left)
    out.push_back({u.firstSample, u.endSample, u.firstTile, u.endTile, int(u.includesSplats)});
  return out;
}

RenderPosition positionFrom(const Json& j) {
  RenderPosition p;
  forEachFigure(p, [&](const char* name, auto& value) { j.at(name).get_to(value); });
  return p;
}

} // namespace

void writeCheckpoint(const std::string& fileName, Checkpoint& c) {
  const PixelBounds& b = c.film.bounds();
  Json parts = Json::array(), classes = Json::array();
  for (const Checkpoint::Part& p : c.parts) parts.push_back({p.seed, p.first, p.end});
  for (const PathClass& k : c.classes) classes.push_back({k.name, k.expression});
  const Json json = {{"identity", c.identity},
                     {"metadata", c.metadata},
                     {"imaging_ratio", c.imagingRatio},
                     {"classes", classes},
                     {"parts", parts},
                     {"position", toJson(c.position)},
                     {"left", toJson(c.position.left)},
                     {"adaptive", c.allocation.has_value()},
                     {"splat_unit", c.film.splats() ? c.film.splats()->unit() : 0},
                     {"film", {b.x0, b.y0, b.x1, b.y1}}};
  const std::string header = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  const uint64_t size = header.size();
  AtomicFile file(fileName);
  uint64_t sum = 0;
  const auto write = [&](std::span<const std::byte> bytes) {
    sum = checksum(sum, bytes);
    file.write(bytes.data(), bytes.size());
  };
  file.write(MAGIC.data(), MAGIC.size());
  write(std::as_bytes(std::span(&size, 1)));
  write(std::as_bytes(std::span(header)));
  for (const std::span<std::byte> part : numbersOf(c)) write(part);
  file.write(&sum, sizeof sum);
  file.commit();
}

Checkpoint Checkpoint::read(const std::string& fileName) {
  const auto fail = [&](const std::string& why) { throw Error(fileName + ": " + why); };
  requireReadable(fileName);
  errno = 0;
  std::ifstream in(fileName, std::ios::binary | std::ios::ate);
  if (!in) fail(std::string("cannot be read: ") + std::strerror(errno));
  const auto fileBytes = static_cast<uint64_t>(in.tellg());
  in.seekg(0);
  uint64_t sum = 0;
  const auto take = [&](std::span<std::byte> bytes) {
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!in) fail("the checkpoint is cut off");
    sum = checksum(sum, bytes);
  };
  std::string magic(MAGIC.size(), '\0');
  if (!in.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != MAGIC)
    fail("is not a checkpoint of this version of Recurse, which --checkpoint writes");
  uint64_t size = 0;
  take(std::as_writable_bytes(std::span(&size, 1)));
  if (size > MAX_HEADER) fail("the checkpoint is damaged");
  std::string header(size, '\0');
  take(std::as_writable_bytes(std::span(header)));
  try {
    const Json json = Json::parse(header);
    std::vector<PathClass> classes;
    for (const Json& k : json.at("classes")) classes.push_back({k.at(0), k.at(1)});
    const Json& f = json.at("film");
    const PixelBounds bounds{f.at(0), f.at(1), f.at(2), f.at(3)};
    // The remaining file must be as long as the header says, before memory is allocated for it.
    const uint64_t left = fileBytes - MAGIC.size() - sizeof size - header.size();
    const double pixels = double(bounds.width()) * double(bounds.height());
    const bool adaptive = json.at("adaptive");
    const double splatUnit = json.at("splat_unit");
    if (bounds.x1 <= bounds.x0 || bounds.y1 <= bounds.y0 || classes.empty() ||
        Film::bytes(pixels, double(classes.size())) + (adaptive ? SampleAllocation::bytes(pixels) : 0) +
                (splatUnit > 0 ? SplatPlane::bytes(pixels, double(classes.size())) : 0) + sizeof sum !=
            double(left))
      fail("the checkpoint is damaged or cut off");
    Checkpoint c{json.at("identity"),
                 json.at("metadata"),
                 json.at("imaging_ratio"),
                 classes,
                 {},
                 positionFrom(json.at("position")),
                 Film(bounds, classes.size()),
                 {}};
    if (adaptive) c.allocation.emplace(bounds, c.imagingRatio);
    if (splatUnit > 0) c.film.enableSplats(splatUnit);
    if (const Json& left = json.at("left"); !left.is_null()) {
      c.position.left.emplace();
      for (const Json& u : left)
        c.position.left->push_back({u.at(0), u.at(1), u.at(2), u.at(3), u.at(4).get<int>() != 0});
    }
    for (const Json& p : json.at("parts")) c.parts.push_back({p.at(0), p.at(1), p.at(2)});
    if (c.parts.empty()) fail("the checkpoint is damaged");
    for (const std::span<std::byte> part : numbersOf(c)) take(part);
    const uint64_t expected = sum;
    take(std::as_writable_bytes(std::span(&size, 1)));
    if (size != expected || in.peek() != std::ifstream::traits_type::eof()) fail("the checkpoint is damaged");
    return c;
  } catch (const Json::exception&) {
    fail("the checkpoint is damaged");
    throw;
  }
}

void requireSame(const std::string& fileName, const std::map<std::string, std::string>& identity,
                 const std::map<std::string, std::string>& other) {
  std::string differences;
  for (const auto& [name, value] : identity) {
    const auto there = other.find(name);
    if (there == other.end() || there->second != value)
      differences += "\n  " + name + ": " + (there == other.end() ? "not said" : there->second) +
                     " in the checkpoint, " + value + " here";
  }
  if (!differences.empty()) throw Error(fileName + ": is a render with other settings:" + differences);
}

std::string missingSamples(const Checkpoint& c) {
  const auto said = c.identity.find("samples per pixel");
  const int64_t wanted = said == c.identity.end() ? 0 : std::atoll(said->second.c_str());
  if (wanted == 0) return {};
  if (c.allocation)
    return c.position.sample < wanted ? "samples from " + std::to_string(c.position.sample) + " on" : "";
  const auto distribution = c.identity.find("sample distribution");
  if (distribution != c.identity.end() && distribution->second != UNIFORM_SAMPLES) return {};
  std::map<uint64_t, std::vector<Checkpoint::Part>> seeds;
  uint64_t each = 0;
  for (const Checkpoint::Part& p : c.parts) {
    seeds[p.seed].push_back(p);
    each += uint64_t(p.end - p.first);
  }
  std::string out;
  const auto add = [&](int64_t first, int64_t end, uint64_t seed) {
    out += (out.empty() ? "samples " : ", ") + std::to_string(first) + ":" + std::to_string(end) +
           (seeds.size() > 1 ? " of seed " + std::to_string(seed) : "");
  };
  for (auto& [seed, parts] : seeds) {
    std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    int64_t next = 0;
    for (const Checkpoint::Part& p : parts) {
      if (p.first > next) add(next, p.first, seed);
      next = std::max(next, p.end);
    }
    if (next < wanted) add(next, wanted, seed);
  }
  size_t behind = 0;
  for (size_t i = 0; i < c.film.bounds().area(); ++i) behind += c.film.samples(i) < each;
  if (behind > 0)
    out += (out.empty() ? "" : ", and ") + ("some samples of " + std::to_string(behind)) + " pixels";
  return out;
}

void merge(Checkpoint& into, const Checkpoint& other, const std::string& fileName) {
  requireSame(fileName, into.identity, other.identity);
  for (const Checkpoint::Part& p : other.parts)
    for (const Checkpoint::Part& q : into.parts)
      if (p.seed == q.seed && p.first < q.end && q.first < p.end)
        throw Error(fileName + ": samples " + std::to_string(std::max(p.first, q.first)) + " to " +
                    std::to_string(std::min(p.end, q.end) - 1) + " of seed " + std::to_string(p.seed) +
                    " are in the sum already and would be counted twice");
  if (into.film.splats() && other.film.splats() && into.film.splats()->unit() != other.film.splats()->unit())
    throw Error(fileName + ": its film of light paths has another unit and cannot be added");
  into.film.add(other.film);
  into.allocation.reset();
  into.parts.insert(into.parts.end(), other.parts.begin(), other.parts.end());
}

} // namespace recurse
