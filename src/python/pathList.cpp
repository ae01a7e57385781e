/** @file
 * Record of a pixel as rows, one for each vertex and one for each contribution.
 */
#include "python/pathList.h"

#include <algorithm>
#include <bit>

#include "python/recordArrays.h"

namespace recurse::python {

namespace {

int32_t vertexOf(const PathRecorder& record, int step) {
  return step == CAMERA_STEP ? -1 : record.steps()[size_t(step)].vertex;
}

PathVertexRecord vertexRow(const Scene& scene, const PathRecorder& record, const RecordedVertex& v) {
  PathVertexRecord out{};
  out.previous = vertexOf(record, v.step);
  out.event = {'E'};
  if (v.step != CAMERA_STEP) {
    const RecordedStep& step = record.steps()[size_t(v.step)];
    out.event = {"SDV"[size_t(step.event)]};
    out.pdf = step.pdf;
    out.pdfReverse = step.pdfReverse;
  }
  out.position = worldPosition(scene, v.position);
  out.normal = floats(v.normal);
  out.throughput = floats(v.throughput);
  return out;
}

PathContributionRecord contributionRow(const PathRecorder& record, const RecordedContribution& c) {
  PathContributionRecord out{};
  const RecordedSource& source = c.source;
  const bool isAtVertex = source.vertex != NOT_RECORDED;
  out.vertex = isAtVertex ? source.vertex : vertexOf(record, source.step);
  out.technique = int32_t(source.technique);
  const int step = isAtVertex ? record.vertices()[size_t(source.vertex)].step : source.step;
  const std::string path = (step == CAMERA_STEP ? "" : record.letters(step)) + "E";
  std::copy_n(path.begin(), std::min(path.size(), out.path.size()), out.path.begin());
  out.weight = source.weight;
  out.pdf = source.pdf;
  out.otherPdf = source.otherPdf;
  out.radiance = floats(c.radiance);
  const LayerMask classes = LayerMask(c.classes >> 1);
  out.pathClass = classes == 0 ? -1 : int32_t(std::countr_zero(classes));
  return out;
}

} // namespace

PathLists listPaths(const Scene& scene, const RecordedPixel& pixel) {
  const PathRecorder& record = pixel.record;
  PathLists out;
  out.value = pixel.value();
  for (size_t i = 0; i < record.samples().size(); ++i) {
    const bool isLast = i + 1 == record.samples().size();
    const size_t end = isLast ? record.vertices().size() : record.samples()[i + 1].firstVertex;
    for (size_t v = record.samples()[i].firstVertex; v < end; ++v) {
      out.vertices.push_back(vertexRow(scene, record, record.vertices()[v]));
      out.vertices.back().sample = int32_t(record.samples()[i].index);
    }
    for (size_t c = record.samples()[i].firstContribution; c < record.endContribution(i); ++c) {
      out.contributions.push_back(contributionRow(record, record.contributions()[c]));
      out.contributions.back().sample = int32_t(record.samples()[i].index);
    }
  }
  return out;
}

} // namespace recurse::python
