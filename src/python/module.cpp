/** @file
 * Functions of Recurse that the Python package calls, as its module `_core`.
 */
#include <mutex>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "apps/options/developOptions.h"
#include "python/background.h"
#include "python/commandOptions.h"
#include "python/pythonScene.h"
#include "recurse/model/scene/plugIns.h"
#include "recurse/pathclasses/classesReport.h"
#include "recurse/report/compare/compare.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace recurse::python {

namespace {

/** Name of a parameter type in scene files. */
std::string typeName(ParameterType type) {
  switch (type) {
  case ParameterType::BOOLEAN:
    return "bool";
  case ParameterType::INTEGER:
    return "integer";
  case ParameterType::REAL:
    return "float";
  case ParameterType::POINT2:
    return "point2";
  case ParameterType::VECTOR2:
    return "vector2";
  case ParameterType::POINT3:
    return "point3";
  case ParameterType::VECTOR3:
    return "vector3";
  case ParameterType::NORMAL:
    return "normal";
  case ParameterType::STRING:
    return "string";
  case ParameterType::SPECTRUM:
    break;
  }
  return "spectrum";
}

py::dict described(const ParameterSpec& spec) {
  return py::dict("name"_a = spec.name, "type"_a = typeName(spec.type), "default"_a = spec.defaultText,
                  "description"_a = spec.description, "range"_a = rangeText(spec), "count"_a = spec.count,
                  "required"_a = spec.required, "textured"_a = spec.textured, "ignored"_a = spec.ignored,
                  "choices"_a = spec.choices);
}

template <class R> void describe(const R& registry, py::list& out) {
  for (const auto& entry : registry.entries()) {
    py::list parameters;
    for (const ParameterSpec& spec : entry.parameters) parameters.append(described(spec));
    out.append(py::dict("kind"_a = registry.kind(), "name"_a = entry.name, "summary"_a = entry.summary,
                        "parameters"_a = parameters, "examples"_a = entry.examples));
  }
}

/** List of all plug-ins with their parameters. */
py::list plugInList() {
  const PlugIns& all = plugIns();
  py::list out;
  describe(all.shapes, out);
  describe(all.imports, out);
  describe(all.materials, out);
  describe(all.textures, out);
  describe(all.lights, out);
  describe(all.areaLights, out);
  describe(all.media, out);
  describe(all.cameras, out);
  describe(all.filters, out);
  describe(all.films, out);
  describe(all.samplers, out);
  describe(all.integrators, out);
  return out;
}

using Pixels = py::array_t<float, py::array::c_style | py::array::forcecast>;

/** Copies rows of pixels into an image with these channels. Throws Error (BAD_USAGE) for a wrong shape. */
std::shared_ptr<Image> imageOf(const Pixels& pixels, std::vector<std::string> channels) {
  if (pixels.ndim() != 3 || size_t(pixels.shape(2)) != channels.size())
    throw Error("a picture is an array of height, width and " + std::to_string(channels.size()) + " channels",
                ExitStatus::BAD_USAGE);
  auto image = std::make_shared<Image>(int(pixels.shape(1)), int(pixels.shape(0)), std::move(channels));
  std::copy_n(pixels.data(), image->pixels.size(), image->pixels.begin());
  return image;
}

/** Pixels as an array without a copy: the array owns the image. */
py::array arrayOf(const std::shared_ptr<Image>& image) {
  using Shared = std::shared_ptr<Image>;
  const py::capsule owner(new Shared(image), [](void* p) { delete static_cast<Shared*>(p); });
  return py::array_t<float>({image->height, image->width, int(image->channels.size())}, image->pixels.data(),
                            owner);
}

std::vector<PathClass> pathClasses(const std::vector<std::pair<std::string, std::string>>& given) {
  std::vector<PathClass> out;
  for (const auto& [name, expression] : given) out.push_back({name, expression});
  return out;
}

/** Progress of a render, handed from its threads to Python's. */
class ProgressMailbox {
 public:
  void put(const RenderProgress& progress) {
    const std::lock_guard guard(mutex);
    latest = progress;
  }
  std::optional<RenderProgress> take() {
    const std::lock_guard guard(mutex);
    return std::exchange(latest, {});
  }

 private:
  std::mutex mutex;
  std::optional<RenderProgress> latest;
};

py::tuple renderScene(const std::shared_ptr<PythonScene>& scene, const std::vector<std::string>& options,
                      const std::vector<std::pair<std::string, std::string>>& classes, bool error,
                      bool samples, const std::vector<std::string>& features, const py::object& progress) {
  const RenderRequest request{options, pathClasses(classes), {error, samples}, features};
  RenderResult result;
  ProgressMailbox mailbox;
  const auto look = [&] {
    const std::optional<RenderProgress> p = mailbox.take();
    if (!p || progress.is_none()) return;
    const py::object answer =
        progress(py::dict("phase"_a = p->phase, "fraction"_a = p->fraction, "elapsed"_a = p->elapsed,
                          "seconds_left"_a = p->secondsLeft, "samples_per_pixel"_a = p->samplesPerPixel,
                          "rays_per_second"_a = p->raysPerSecond, "error"_a = p->error));
    if (answer.is(py::bool_(false))) PythonScene::stop();
  };
  runInBackground([&] { result = scene->render(request, [&](const RenderProgress& p) { mailbox.put(p); }); },
                  look, &PythonScene::stop);
  return py::make_tuple(result.image, result.statistics);
}

void doNothing() {}

std::shared_ptr<PythonScene> load(const std::string& name, const std::optional<std::string>& text,
                                  const std::string& directory, bool lenient) {
  std::shared_ptr<PythonScene> out;
  const auto shared = text ? std::make_shared<const std::string>(*text) : nullptr;
  runInBackground([&] { out = std::make_shared<PythonScene>(name, shared, directory, lenient); }, doNothing,
                  doNothing);
  return out;
}

/** Array that owns the rows. */
template <class T> py::array rowsOf(std::vector<T> rows) {
  auto* list = new std::vector<T>(std::move(rows));
  const py::capsule owner(list, [](void* p) { delete static_cast<std::vector<T>*>(p); });
  return py::array_t<T>({py::ssize_t(list->size())}, list->data(), owner);
}

py::array photons(const std::shared_ptr<PythonScene>& scene, uint64_t count, uint64_t seed, int maxDepth,
                  const std::vector<std::string>& classes) {
  PhotonRequest request{count, seed, maxDepth, {}};
  for (const std::string& expression : classes) request.classes.push_back(PathAutomaton::compile(expression));
  std::vector<PhotonRecord> list;
  runInBackground([&] { list = scene->photons(request); }, doNothing, doNothing);
  return rowsOf(std::move(list));
}

py::tuple paths(const std::shared_ptr<PythonScene>& scene, const std::vector<std::string>& options,
                const std::vector<std::pair<std::string, std::string>>& classes, std::pair<int, int> pixel,
                int64_t samples) {
  PathLists lists;
  runInBackground(
      [&] {
        lists = scene->paths({options, pathClasses(classes), {}, {}}, pixel.first, pixel.second, samples);
      },
      doNothing, &PythonScene::stop);
  const Rgb value = lists.value;
  return py::make_tuple(rowsOf(std::move(lists.vertices)), rowsOf(std::move(lists.contributions)),
                        py::make_tuple(value.r, value.g, value.b));
}

/** Raises the Python exception of a SceneError, with its locations in the scene files. */
void raiseSceneError(PyObject* type, const SceneError& error) {
  const py::object raised = py::reinterpret_borrow<py::object>(type)(std::string(error.what()));
  py::list places;
  for (const Diagnostic& d : error.diagnostics()) {
    if (d.severity != Severity::ERROR) continue;
    places.append(py::dict("file"_a = d.location.source ? d.location.source->name : "",
                           "line"_a = d.location.line, "column"_a = d.location.column,
                           "message"_a = d.message, "accepted"_a = d.accepted));
  }
  raised.attr("errors") = places;
  for (const char* name : {"file", "line", "column", "message"})
    raised.attr(name) = places.empty() ? py::object(py::none()) : py::object(places[0][name]);
  PyErr_SetObject(type, raised.ptr());
}

} // namespace

} // namespace recurse::python

PYBIND11_MODULE(_core, m) {
  using namespace recurse;
  using namespace recurse::python;
  m.doc() = "What the package recurse is made of; see there.";

  static const py::exception<Error> errorType(m, "Error", PyExc_RuntimeError);
  static const py::exception<SceneError> sceneErrorType(m, "SceneError", errorType.ptr());
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const SceneError& error) {
      raiseSceneError(sceneErrorType.ptr(), error);
    } catch (const Error& error) {
      PyErr_SetString(errorType.ptr(), error.what());
    }
  });

  PYBIND11_NUMPY_DTYPE_EX(PhotonRecord, position, "position", direction, "direction", normal, "normal", power,
                          "power", path, "path", event, "event", pathClass, "class");

  PYBIND11_NUMPY_DTYPE_EX(PathVertexRecord, sample, "sample", previous, "previous", event, "event", position,
                          "position", normal, "normal", throughput, "throughput", pdf, "pdf", pdfReverse,
                          "pdf_reverse");
  PYBIND11_NUMPY_DTYPE_EX(PathContributionRecord, sample, "sample", vertex, "vertex", technique, "technique",
                          path, "path", weight, "weight", pdf, "pdf", otherPdf, "other_pdf", radiance,
                          "radiance", pathClass, "class");

  py::class_<Image, std::shared_ptr<Image>>(m, "Image")
      .def(py::init(&imageOf))
      .def_readonly("channels", &Image::channels)
      .def_readonly("metadata", &Image::metadata)
      .def("array", &arrayOf);
  py::class_<PythonScene, std::shared_ptr<PythonScene>>(m, "Scene")
      .def("render", &renderScene)
      .def("photons", &photons)
      .def("paths", &paths)
      .def("report", &PythonScene::report)
      .def("take_warnings", &PythonScene::takeWarnings);

  m.def("load", &load);
  m.def("technique_name", [](int technique) { return techniqueName(static_cast<PathTechnique>(technique)); });
  m.def("plug_ins", &plugInList);
  m.def("read_image",
        [](const std::string& name) { return std::make_shared<Image>(readImage(FileReference{name})); });
  m.def("write_image",
        [](const Image& image, const std::string& name, const std::vector<std::string>& options) {
          apps::PictureWriter(commandOptions<apps::DevelopOptions>(options)).write(name, image);
        });
  m.def("develop", [](const Image& image, const std::vector<std::string>& options) {
    Developed developed = develop(image, commandOptions<apps::DevelopOptions>(options).settings());
    return py::make_tuple(std::make_shared<Image>(std::move(developed.picture)), developed.stops);
  });
  m.def("compare", [](const Image& image, const Image& reference, bool flip) {
    Comparison comparison = compareImages(image, reference);
    if (flip) addFlip(comparison, image, reference);
    return comparisonJson(comparison);
  });
  m.def("classes", [](const std::vector<std::pair<std::string, std::string>>& classes) {
    return analyseClasses(pathClasses(classes)).text();
  });
  m.def("named_classes", [] {
    py::list out;
    for (const NamedPathClass& c : namedPathClasses())
      out.append(py::make_tuple(c.name, c.expression, c.meaning));
    return out;
  });
  m.def("default_classes", [](bool withMedia) {
    py::list out;
    for (const PathClass& c : defaultStillClasses(withMedia))
      out.append(py::make_tuple(c.name, c.expression));
    return out;
  });
  m.def("is_in_class", [](const std::string& expression, const std::string& path) {
    return PathAutomaton::compile(expression).accepts(path);
  });
}
