/** @file
 * Lists of a recorded pixel: vertices, steps, estimates, contributions, vertices of light paths.
 */
#include "report/inspect/pixelJson.h"

#include <bit>
#include <cmath>

namespace recurse {

namespace {

/** Position of the lowest bit among `count` bits from `first` on; -1 where none is set. */
int firstOf(LayerMask mask, size_t first, size_t count) {
  if (count == 0) return -1;
  const LayerMask range = (mask >> first) & (~LayerMask(0) >> (64 - count));
  return range == 0 ? -1 : std::countr_zero(range);
}

std::string lobeName(LobeSet lobe) {
  if (lobe & MIRROR) return "mirror";
  if (lobe & REFRACTION) return "refraction";
  if (lobe & TRANSMISSION) return "transmission";
  return lobe & REFLECTION ? "reflection" : "";
}

/** Non-delta lobes, of which light samples, connections and merges evaluate the sum. */
std::string nonDeltaNames(LobeSet lobes, bool inMedium) {
  if (inMedium) return "phase";
  const bool both = (lobes & NON_DELTA_LOBES) == NON_DELTA_LOBES;
  return both ? "reflection, transmission" : lobeName(lobes & NON_DELTA_LOBES);
}

} // namespace

Json shortened(double x) {
  if (!std::isfinite(x)) return nullptr;
  if (x == 0) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(x))) - 5);
  return std::isnormal(unit) ? std::round(x / unit) * unit : x;
}

Json numbers(const Vec3f& v) {
  return {shortened(double(v.x)), shortened(double(v.y)), shortened(double(v.z))};
}

Json numbers(const Rgb& c) {
  return {shortened(double(c.r)), shortened(double(c.g)), shortened(double(c.b))};
}

size_t classCount(const PathClasses& classes) {
  return classes.isTransient() ? 1 : std::min<size_t>(classes.layerCount(), 64);
}

MaskReader::MaskReader(const PathClasses& classes, const Inspection& inspection)
    : shown(inspection.shownClasses ? inspection.shownClasses : classCount(classes)),
      lamps(inspection.lamps.size()), depths(inspection.depths),
      lampClasses(inspection.shownClasses ? classes.layerCount() - shown - depths : 0) {
  for (size_t i = 0; i < shown; ++i)
    if (classes.classes()[i].expression != "all") telling |= LayerMask(1) << i;
}

uint8_t MaskReader::classOf(LayerMask mask) const {
  const int found = hasClasses() ? firstOf(mask & telling, 0, shown) : -1;
  return found < 0 ? NO_CLASS : static_cast<uint8_t>(found);
}

int MaskReader::lampOf(LayerMask mask) const {
  if (lampClasses > 0) return firstOf(mask, shown, lampClasses);
  return lamps == 1 ? 0 : -1;
}

uint8_t MaskReader::depthOf(LayerMask mask) const {
  return static_cast<uint8_t>(1 + firstOf(mask, shown + lampClasses, depths));
}

Json PixelJson::of(const RecordedPixel& pixel) {
  const PathRecorder& record = pixel.record;
  Json out = {
      {"x", pixel.x}, {"y", pixel.y}, {"value", numbers(pixel.value())}, {"splats", numbers(pixel.splats)}};
  for (const char* name : {"samples", "vertices", "steps", "estimates", "contributions", "lightVertices"})
    out[name] = Json::array();
  for (size_t i = 0; i < record.samples().size(); ++i)
    out["samples"].push_back(sample(record.samples()[i], record.endContribution(i)));
  for (const RecordedVertex& v : record.vertices()) out["vertices"].push_back(vertex(v));
  for (const RecordedStep& s : record.steps())
    out["steps"].push_back({s.vertex, std::string(1, "SDV"[size_t(s.event)]), table.index(lobeName(s.lobe)),
                            shortened(double(s.pdf)), shortened(double(s.pdfReverse)), numbers(s.throughput),
                            numbers(s.direction)});
  for (const RecordedEstimate& e : record.estimates())
    out["estimates"].push_back({e.vertex, e.caustic, shortened(double(e.radius)), e.photons});
  for (const RecordedContribution& c : record.contributions())
    out["contributions"].push_back(contribution(record, c));
  for (const RecordedLightVertex& v : record.lightVertices) out["lightVertices"].push_back(lightVertex(v));
  return out;
}

Json PixelJson::sample(const RecordedSample& s, size_t end) {
  return {s.firstContribution, end, numbers(s.origin), numbers(s.direction), numbers(s.total)};
}

Json PixelJson::vertex(const RecordedVertex& v) {
  const std::string object = v.inMedium ? "medium" : scene.objectName(v.object);
  return {v.step,
          numbers(v.position),
          numbers(v.normal),
          table.index(object),
          table.index(v.material ? scene.materialName(v.material) : ""),
          v.inMedium,
          numbers(v.throughput),
          table.index(nonDeltaNames(v.lobes, v.inMedium)),
          v.inMedium ? Json::array() : surfaceNames(v.object, v.material)};
}

Json PixelJson::surfaceNames(uint32_t object, const Material* material) {
  Json out = Json::array();
  for (const std::string& name : names.objects[object]) out.push_back(table.index(name));
  for (const std::string& name : names.materials[material ? material->number : 0])
    out.push_back(table.index(name));
  return out;
}

Json PixelJson::namesOf(const RecordedLightVertex& v) {
  if (v.kind == LightVertexKind::SURFACE) return surfaceNames(v.object, v.material);
  return v.kind == LightVertexKind::MEDIUM ? Json::array() : Json(nullptr);
}

std::string PixelJson::objectOf(const RecordedLightVertex& v) const {
  switch (v.kind) {
  case LightVertexKind::START:
    return "light";
  case LightVertexKind::MEDIUM:
    return "medium";
  case LightVertexKind::SURFACE:
    return scene.objectName(v.object);
  case LightVertexKind::ESCAPE:
    break;
  }
  return "";
}

Json PixelJson::lightVertex(const RecordedLightVertex& v) {
  return {v.previous,
          std::string(1, "SDV"[size_t(v.event)]),
          numbers(v.position),
          numbers(v.flux),
          table.index(objectOf(v)),
          table.index(v.material ? scene.materialName(v.material) : ""),
          table.index(nonDeltaNames(v.lobes, v.kind == LightVertexKind::MEDIUM)),
          table.index(lobeName(v.lobe)),
          shortened(double(v.pdf)),
          shortened(double(v.pdfReverse)),
          namesOf(v)};
}

Json PixelJson::weights(const PathRecorder& record, const RecordedSource& s) {
  Json out = Json::array();
  for (size_t i = s.firstWeight; i < s.firstWeight + s.weightCount; ++i) {
    const RecordedWeight& w = record.weights[i];
    out.push_back({table.index(techniqueName(w.technique)), w.cameraVertices, shortened(double(w.weight))});
  }
  return out;
}

Json PixelJson::contribution(const PathRecorder& record, const RecordedContribution& c) {
  const RecordedSource& s = c.source;
  const char* omission = s.omission();
  return {table.index(techniqueName(s.technique)),
          s.vertex,
          s.step,
          s.estimate,
          numbers(s.end),
          s.isInfinite,
          shortened(double(s.weight)),
          shortened(double(s.pdf)),
          shortened(double(s.otherPdf)),
          reader.hasClasses() ? reader.classOf(c.classes) : UNCLASSIFIED,
          numbers(c.radiance),
          s.lightVertex,
          {shortened(double(s.vertexPdf)), shortened(double(s.vertexPdfReverse)),
           shortened(double(s.lightVertexPdf)), shortened(double(s.lightVertexPdfReverse))},
          weights(record, s),
          table.index(omission ? omission : ""),
          s.panes,
          reader.lampOf(c.classes)};
}

} // namespace recurse
