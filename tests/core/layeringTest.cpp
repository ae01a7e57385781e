/** @file
 * Layout of the repository, from its files: includes point downwards without cycles, every file has a
 * description, plug-ins are leaves, and the list of plug-ins is complete. The checker itself is tested with
 * small synthetic trees.
 */
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <unistd.h>
#include <vector>

namespace fs = std::filesystem;

namespace {

const std::set<std::string> INTERFACE_MODULES = {"core",      "scene",  "model", "pathclasses",
                                                 "transport", "render", "report"};
const std::set<std::string> PLUG_IN_FOLDERS = {"bsdfs",    "shapes",      "lights",   "media",
                                               "phases",   "cameras",     "textures", "filters",
                                               "samplers", "integrators", "tonemaps", "importers"};

/** Modules that each module may include in addition to itself. */
const std::map<std::string, std::set<std::string>> MAY_INCLUDE = [] {
  std::map<std::string, std::set<std::string>> m;
  m["core"] = {};
  m["scene"] = {"core"};
  m["model"] = {"core", "scene"};
  m["pathclasses"] = {"core"};
  m["transport"] = {"core", "scene", "model", "pathclasses"};
  m["plugins"] = m["render"] = {"core", "scene", "model", "pathclasses", "transport"};
  m["report"] = {"core", "scene", "model", "pathclasses", "transport", "render"};
  m["apps"] = {"core", "scene", "model", "pathclasses", "transport", "render", "report"};
  m["mpi"] = {"core", "model", "pathclasses", "transport", "render", "apps"};
  m["python"] = {"core", "scene", "model", "pathclasses", "transport", "render", "report", "apps"};
  for (const std::string& folder : PLUG_IN_FOLDERS) m[folder] = {"core", "scene", "model"};
  m["integrators"] = {"core", "scene", "model", "pathclasses", "transport"};
  return m;
}();

/** Folders of transport that each folder may include in addition to itself. */
const std::map<std::string, std::set<std::string>> TRANSPORT_MAY_INCLUDE = [] {
  std::map<std::string, std::set<std::string>> m;
  m["integrator"] = m["photonmap"] = m["guiding"] = {};
  m["weights"] = m["paths"] = {"integrator"};
  m["direct"] = {"integrator", "weights", "paths"};
  m["media"] = {"integrator", "weights", "paths", "photonmap"};
  m["emission"] = {"integrator", "weights", "paths", "direct", "photonmap", "media"};
  m["forward"] = m["emission"];
  m["forward"].insert("emission");
  m["density"] = m["learning"] = m["forward"];
  m["density"].insert("forward");
  m["learning"].insert({"forward", "guiding"});
  return m;
}();

/** Folders of integrators that each folder may include in addition to itself. */
const std::map<std::string, std::set<std::string>> INTEGRATORS_MAY_INCLUDE = {
    {"photonmap", {"path"}}, {"auto", {"path", "photonmap"}}};

/** Modules whose private headers a module may include in addition to its own. */
const std::map<std::string, std::set<std::string>> MAY_INCLUDE_PRIVATE = {{"integrators", {"transport"}},
                                                                          {"render", {"transport"}},
                                                                          {"apps", {"report", "transport"}},
                                                                          {"mpi", {"apps", "render"}},
                                                                          {"python", {"apps", "transport"}}};

constexpr size_t MAX_FILES_IN_FOLDER = 16;

/** Source file with its path, and its includes within the project. */
struct SourceFile {
  std::string module;
  std::string folder;       ///< folder within the module; empty: none
  bool isInterface = false; ///< in include/recurse
  std::string text;
  std::vector<std::string> includes; ///< paths from the root
};

/** Replaces comments by blanks, and keeps the lines. */
std::string withoutComments(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size();) {
    size_t end = i;
    if (text.compare(i, 2, "/*") == 0)
      end = std::min(text.find("*/", i + 2), text.size() - 2) + 2;
    else if (text.compare(i, 2, "//") == 0)
      end = std::min(text.find('\n', i), text.size());
    if (end == i) {
      out += text[i++];
      continue;
    }
    for (; i < end; ++i)
      if (text[i] == '\n') out += '\n';
  }
  return out;
}

/** Finds all violations in the tree at `root`; one sentence each. */
class LayeringChecker {
 public:
  explicit LayeringChecker(const fs::path& root) : root(root) {}

  std::vector<std::string> check() {
    readFolder("include/recurse");
    readFolder("src");
    for (const auto& [path, file] : files) {
      checkFile(path, file);
      checkIncludes(path, file);
    }
    findCycles();
    findTypesDefinedTwice();
    checkFolders();
    checkPlugInList();
    return complaints;
  }

  size_t fileCount() const { return files.size(); }

 private:
  void complain(const std::string& what) { complaints.push_back(what); }

  void readFolder(const std::string& folder) {
    if (!fs::is_directory(root / folder)) return complain("there is no folder " + folder);
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension();
      if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
      const fs::path below = entry.path().lexically_relative(root / folder);
      std::ifstream stream(entry.path());
      SourceFile file;
      file.module = std::distance(below.begin(), below.end()) > 1 ? below.begin()->string() : "";
      if (std::distance(below.begin(), below.end()) > 2) file.folder = std::next(below.begin())->string();
      file.isInterface = folder != "src";
      file.text.assign(std::istreambuf_iterator<char>(stream), {});
      readIncludes(file);
      files[entry.path().lexically_relative(root).generic_string()] = file;
    }
  }

  static void readIncludes(SourceFile& file) {
    static const std::regex INCLUDE(R"((?:^|\n)[ \t]*#[ \t]*include[ \t]*(["<])([^">\n]+)[">])");
    const std::string code = withoutComments(file.text);
    for (std::sregex_iterator i(code.begin(), code.end(), INCLUDE), end; i != end; ++i) {
      const std::string name = (*i)[2];
      if (name.starts_with("recurse/"))
        file.includes.push_back("include/" + name);
      else if ((*i)[1] == "\"")
        file.includes.push_back("src/" + name);
    }
  }

  void checkFile(const std::string& path, const SourceFile& file) {
    if (file.isInterface ? !INTERFACE_MODULES.contains(file.module) : !MAY_INCLUDE.contains(file.module))
      complain(path + " is in no module");
    const size_t said = file.text.find("@file");
    if (!file.text.starts_with("/**") || said == std::string::npos || said > file.text.find("*/"))
      complain(path + " does not open with a comment /** @file ... */");
    if (PLUG_IN_FOLDERS.contains(file.module) && file.folder.empty() && path.ends_with(".h"))
      complain(path + " is a header in a folder of plug-ins: it belongs into a folder below");
    if (file.isInterface && path.ends_with(".cpp")) complain(path + " belongs into src");
    static const std::regex INTRINSIC(R"(\b_mm\d*_|\b__m(128|256|512)|mmintrin\.h)");
    if (path != "include/recurse/core/math/float8.h" && std::regex_search(file.text, INTRINSIC))
      complain(path + " knows the processor, which only float8.h may");
  }

  void checkIncludes(const std::string& path, const SourceFile& file) {
    const auto allowed = MAY_INCLUDE.find(file.module);
    for (const std::string& name : file.includes) {
      const auto included = files.find(name);
      if (included == files.end()) {
        complain(path + " includes " + name + ", which does not exist");
        continue;
      }
      const SourceFile& other = included->second;
      const bool isUpward = other.module != file.module && allowed != MAY_INCLUDE.end() &&
                            !allowed->second.contains(other.module);
      if (file.isInterface && !other.isInterface)
        complain(path + " is an interface and includes " + name + ", which is not installed");
      else if (isUpward)
        complain(path + " includes " + name + ": " + file.module + " must not see " + other.module);
      else if (!other.isInterface && !maySeePrivate(file, other))
        complain(path + " includes " + name + ", which is private to " + folderOf(name));
      checkFloors(path, file, name, other, "transport", TRANSPORT_MAY_INCLUDE);
      checkFloors(path, file, name, other, "integrators", INTEGRATORS_MAY_INCLUDE);
    }
  }

  /** Checks the includes between folders of the same module. */
  void checkFloors(const std::string& path, const SourceFile& file, const std::string& name,
                   const SourceFile& other, const std::string& module,
                   const std::map<std::string, std::set<std::string>>& mayInclude) {
    if (file.module != module || other.module != module || file.folder == other.folder) return;
    const auto allowed = mayInclude.find(file.folder);
    if (allowed == mayInclude.end() || !allowed->second.contains(other.folder))
      complain(path + " includes " + name + ": " + file.folder + " must not see " + other.folder);
  }

  static std::string folderOf(const std::string& path) {
    return fs::path(path).parent_path().generic_string();
  }

  /** Whether the file may include the header `other` in src. In a subfolder of plug-ins a header is private
   * to the folder, unless no plug-in is in the folder: then all plug-ins of the kind share it. */
  bool maySeePrivate(const SourceFile& file, const SourceFile& other) const {
    if (other.module != file.module) {
      const auto more = MAY_INCLUDE_PRIVATE.find(file.module);
      return file.module == "plugins" ||
             (more != MAY_INCLUDE_PRIVATE.end() && more->second.contains(other.module));
    }
    if (!PLUG_IN_FOLDERS.contains(file.module) || file.folder == other.folder || file.module == "integrators")
      return true;
    for (const auto& [path, sibling] : files)
      if (sibling.module == other.module && sibling.folder == other.folder &&
          sibling.text.find("void register") != std::string::npos)
        return false;
    return true;
  }

  void checkFolders() {
    std::map<std::string, size_t> counts;
    for (const auto& [path, file] : files)
      for (std::string folder = folderOf(path); folder != "src" && folder != "include/recurse";
           folder = folderOf(folder))
        counts[folder] += folder == folderOf(path) ? 1 : 0;
    for (const auto& [folder, count] : counts) {
      if (count > MAX_FILES_IN_FOLDER)
        complain(folder + " has " + std::to_string(count) + " files, more than " +
                 std::to_string(MAX_FILES_IN_FOLDER));
      const bool isSource = folder.starts_with("src/");
      const std::string inSource =
          isSource ? folder : "src" + folder.substr(std::string("include/recurse").size());
      if (!fs::exists(root / inSource / "README.md") && !fs::exists(root / folder / "README.md"))
        complain(folder + " has no README.md");
    }
  }

  /** Unit of a header and the source with the same name: the path without root and extension. */
  static std::string unitOf(const std::string& path) {
    const std::string root = path.starts_with("src/") ? "src/" : "include/recurse/";
    return fs::path(path.substr(root.size())).replace_extension().generic_string();
  }

  void findCycles() {
    std::map<std::string, std::set<std::string>> units;
    for (const auto& [path, file] : files)
      for (const std::string& name : file.includes)
        if (files.contains(name) && unitOf(name) != unitOf(path)) units[unitOf(path)].insert(unitOf(name));
    std::map<std::string, int> state; // 1: being visited, 2: done
    std::vector<std::string> way;
    for (const auto& [unit, others] : units) visit(unit, units, state, way);
  }

  void visit(const std::string& unit, const std::map<std::string, std::set<std::string>>& units,
             std::map<std::string, int>& state, std::vector<std::string>& way) {
    if (state[unit] == 2) return;
    if (state[unit] == 1) {
      std::string circle;
      for (auto i = std::find(way.begin(), way.end(), unit); i != way.end(); ++i) circle += *i + " -> ";
      return complain("includes go in a circle: " + circle + unit);
    }
    state[unit] = 1;
    way.push_back(unit);
    if (const auto others = units.find(unit); others != units.end())
      for (const std::string& other : others->second) visit(other, units, state, way);
    way.pop_back();
    state[unit] = 2;
  }

  /** Two types with the same name in one namespace are undefined behaviour that no compiler reports. Types in
   * an unnamed namespace are private to their file. */
  void findTypesDefinedTwice() {
    static const std::regex LINE(
        R"(\n(?:namespace ([\w:]*) ?\{|(\}) // namespace|(?:struct|class|enum class) (\w+)(?: final)?(?: : [^;\n]*)? \{))");
    std::map<std::string, std::string> definedIn;
    for (const auto& [path, file] : files) {
      std::vector<std::string> namespaces;
      for (std::sregex_iterator i(file.text.begin(), file.text.end(), LINE), end; i != end; ++i) {
        const std::smatch& line = *i;
        if (line[2].matched) {
          if (!namespaces.empty()) namespaces.pop_back();
        } else if (!line[3].matched) {
          namespaces.push_back(line[1]);
        } else if (std::ranges::find(namespaces, "") == namespaces.end()) {
          std::string name;
          for (const std::string& outer : namespaces) name += outer + "::";
          name += line[3];
          const auto [other, isNew] = definedIn.emplace(name, path);
          if (!isNew) complain(path + " defines " + name + ", which " + other->second + " defines too");
        }
      }
    }
  }

  /** All matches of the pattern's first group in the files that `wanted` accepts, with their numbers. */
  template <class Wanted>
  std::map<std::string, int> countNames(const std::string& pattern, const Wanted& wanted) const {
    const std::regex expression(pattern);
    std::map<std::string, int> counts;
    for (const auto& [path, file] : files) {
      if (!wanted(path, file)) continue;
      const std::string code = withoutComments(file.text);
      for (std::sregex_iterator i(code.begin(), code.end(), expression), end; i != end; ++i)
        ++counts[(*i)[1]];
    }
    return counts;
  }

  void checkPlugInList() {
    const std::string list = "src/plugins/list.h";
    const auto listed = countNames(R"(RECURSE_PLUG_IN\s*\(\s*(\w+)\s*\))",
                                   [&](const std::string& path, const SourceFile&) { return path == list; });
    auto defined = countNames(R"(\bvoid\s+register(\w+)\s*\(\s*PlugIns\s*&\s*\w*\s*\)\s*\{)",
                              [](const std::string&, const SourceFile& file) { return !file.isInterface; });
    if (listed.empty()) complain(list + " lists no plug-in");
    for (const auto& [name, times] : listed) {
      if (times > 1) complain(list + " lists " + name + " more than once");
      if (defined[name] != 1)
        complain("register" + name + " of " + list + " is defined " + std::to_string(defined[name]) +
                 " times");
    }
    for (const auto& [name, times] : defined)
      if (!listed.contains(name)) complain("register" + name + " is missing in " + list);
  }

  fs::path root;
  std::map<std::string, SourceFile> files;
  std::vector<std::string> complaints;
};

/** Temporary tree without violations. */
class LayeringCheck : public ::testing::Test {
 protected:
  LayeringCheck() : root(fs::temp_directory_path() / ("recurse-layering-" + std::to_string(getpid()))) {
    fs::remove_all(root);
    write("include/recurse/core/a.h", "#include <vector>\n");
    write("include/recurse/model/m.h", "#include \"recurse/core/a.h\"\n");
    write("include/recurse/transport/integrator/t.h", "#include \"recurse/model/m.h\"\n");
    write("src/model/own.h", "#include \"recurse/model/m.h\"\n// #include \"recurse/report/r.h\"\n");
    write("src/model/user.cpp", "#include \"model/own.h\"\n");
    write("src/bsdfs/b.cpp", "#include \"recurse/model/m.h\"\nvoid registerB(PlugIns& plugIns) {}\n");
    write("src/integrators/i.cpp",
          "#include \"recurse/transport/integrator/t.h\"\nvoid registerI(PlugIns& p) {}\n");
    write("src/plugins/list.h", "RECURSE_PLUG_IN(B)\nRECURSE_PLUG_IN(I)\n");
    write("src/plugins/plugIns.cpp", "#include \"plugins/list.h\"\n#include \"recurse/model/m.h\"\n");
    write("src/apps/main.cpp", "#include <recurse/transport/integrator/t.h>\n");
  }
  ~LayeringCheck() override { fs::remove_all(root); }

  void write(const std::string& path, const std::string& code) {
    writeBare(path, "/** @file\n * A file.\n */\n" + code);
  }
  void writeBare(const std::string& path, const std::string& text) {
    fs::create_directories((root / path).parent_path());
    std::ofstream(root / path) << text;
    for (fs::path folder = fs::path(path).parent_path(); folder.has_parent_path();
         folder = folder.parent_path())
      std::ofstream(root / folder / "README.md") << "# A folder\n";
  }
  /** The only violation; several are joined. */
  std::string complaint() const {
    std::string all;
    for (const std::string& c : LayeringChecker(root).check()) all += (all.empty() ? "" : " | ") + c;
    return all;
  }

  fs::path root;
};

} // namespace

TEST(Layering, OfThisRepository) {
  LayeringChecker checker(RECURSE_SOURCE_DIR);
  for (const std::string& complaint : checker.check()) ADD_FAILURE() << complaint;
  EXPECT_GT(checker.fileCount(), 40u);
}

TEST_F(LayeringCheck, AcceptsASoundTree) { EXPECT_EQ(complaint(), ""); }

TEST_F(LayeringCheck, FindsAnUpwardInclude) {
  write("src/core/up.cpp", "#include \"recurse/model/m.h\"\n");
  EXPECT_EQ(complaint(), "src/core/up.cpp includes include/recurse/model/m.h: core must not see model");
}

TEST_F(LayeringCheck, FindsAnUpwardIncludeInAngleBracketsAndOddSpacing) {
  write("src/scene/a.cpp", "  #  include   <recurse/transport/integrator/t.h>\n");
  EXPECT_EQ(
      complaint(),
      "src/scene/a.cpp includes include/recurse/transport/integrator/t.h: scene must not see transport");
}

TEST_F(LayeringCheck, OnlyIntegratorsAmongThePlugInsSeeTransport) {
  write("src/lights/l.cpp", "#include \"recurse/transport/integrator/t.h\"\n");
  EXPECT_EQ(
      complaint(),
      "src/lights/l.cpp includes include/recurse/transport/integrator/t.h: lights must not see transport");
}

TEST_F(LayeringCheck, NobodySeesTheApps) {
  write("src/apps/options.h", "");
  write("src/report/r.cpp", "#include \"apps/options.h\"\n");
  EXPECT_EQ(complaint(), "src/report/r.cpp includes src/apps/options.h: report must not see apps");
}

TEST_F(LayeringCheck, FindsAnInterfaceThatIncludesAPrivateHeader) {
  write("include/recurse/model/n.h", "#include \"model/own.h\"\n");
  EXPECT_EQ(complaint(),
            "include/recurse/model/n.h is an interface and includes src/model/own.h, which is not installed");
}

TEST_F(LayeringCheck, FindsCircles) {
  write("include/recurse/core/a.h", "#include \"recurse/core/b.h\"\n");
  write("include/recurse/core/b.h", "#include \"recurse/core/c.h\"\n");
  write("include/recurse/core/c.h", "#include \"recurse/core/b.h\"\n");
  EXPECT_EQ(complaint(), "includes go in a circle: core/b -> core/c -> core/b");
}

TEST_F(LayeringCheck, FindsCirclesOfHeadersAndTheirSources) {
  write("include/recurse/core/b.h", "");
  write("include/recurse/core/c.h", "#include \"recurse/core/b.h\"\n");
  write("src/core/b.cpp", "#include \"recurse/core/b.h\"\n#include \"recurse/core/c.h\"\n");
  EXPECT_EQ(complaint(), "includes go in a circle: core/b -> core/c -> core/b");
}

TEST_F(LayeringCheck, FindsTypesThatAreDefinedTwice) {
  write("src/core/a.h", "namespace recurse {\nstruct A {\n};\nnamespace {\nclass B {};\n} // namespace\n"
                        "namespace other {\nclass C {};\n} // namespace other\n} // namespace recurse\n");
  write("src/core/b.h", "namespace recurse {\nclass C {};\nstruct B : C {\n};\n} // namespace recurse\n");
  EXPECT_EQ(complaint(), "");
  write("src/core/c.cpp", "namespace recurse {\nclass A final {\n};\n} // namespace recurse\n");
  EXPECT_EQ(complaint(), "src/core/c.cpp defines recurse::A, which src/core/a.h defines too");
}

TEST_F(LayeringCheck, FindsAMissingHeader) {
  write("src/core/a.cpp", "#include \"recurse/core/gone.h\"\n");
  EXPECT_EQ(complaint(), "src/core/a.cpp includes include/recurse/core/gone.h, which does not exist");
}

TEST_F(LayeringCheck, FindsAFileThatDoesNotSayWhatItIs) {
  writeBare("src/core/a.cpp", "#include <vector>\n/** @file\n * Too late.\n */\n");
  writeBare("src/core/b.cpp", "/** No such word. */\nint x; // @file\n");
  EXPECT_EQ(complaint(), "src/core/a.cpp does not open with a comment /** @file ... */ | "
                         "src/core/b.cpp does not open with a comment /** @file ... */");
}

TEST_F(LayeringCheck, FindsWhatKnowsTheProcessor) {
  write("src/core/a.cpp", "#include <immintrin.h>\n");
  write("src/core/b.cpp", "auto x = _mm256_setzero_ps();\n");
  write("src/core/c.cpp", "int cost_mm_, rest__mm;\n");
  EXPECT_EQ(complaint(), "src/core/a.cpp knows the processor, which only float8.h may | "
                         "src/core/b.cpp knows the processor, which only float8.h may");
}

TEST_F(LayeringCheck, FindsAHeaderAmongPlugIns) {
  write("src/shapes/quadric.h", "");
  EXPECT_EQ(complaint(),
            "src/shapes/quadric.h is a header in a folder of plug-ins: it belongs into a folder below");
}

TEST_F(LayeringCheck, APlugInsHeaderIsPrivateToItsFolder) {
  write("src/bsdfs/coated/coat.h", "");
  write("src/bsdfs/coated/coated.cpp", "#include \"bsdfs/coated/coat.h\"\nvoid registerC(PlugIns& p) {}\n");
  write("src/plugins/list.h", "RECURSE_PLUG_IN(B)\nRECURSE_PLUG_IN(C)\nRECURSE_PLUG_IN(I)\n");
  EXPECT_EQ(complaint(), "");
  write("src/bsdfs/b.cpp", "#include \"bsdfs/coated/coat.h\"\nvoid registerB(PlugIns& plugIns) {}\n");
  EXPECT_EQ(complaint(),
            "src/bsdfs/b.cpp includes src/bsdfs/coated/coat.h, which is private to src/bsdfs/coated");
}

TEST_F(LayeringCheck, HeadersInAFolderWithoutPlugInsAreSharedByTheKind) {
  write("src/bsdfs/microfacet/facets.h", "");
  write("src/bsdfs/b.cpp", "#include \"bsdfs/microfacet/facets.h\"\nvoid registerB(PlugIns& plugIns) {}\n");
  EXPECT_EQ(complaint(), "");
}

TEST_F(LayeringCheck, HeadersInSourceFoldersArePrivateToTheirModule) {
  write("src/bsdfs/b.cpp", "#include \"model/own.h\"\nvoid registerB(PlugIns& plugIns) {}\n");
  EXPECT_EQ(complaint(), "src/bsdfs/b.cpp includes src/model/own.h, which is private to src/model");
}

TEST_F(LayeringCheck, TransportHasFloorsOfItsOwn) {
  write("src/transport/paths/walk.h", "#include \"transport/density/gather.h\"\n");
  write("src/transport/density/gather.h", "");
  EXPECT_EQ(complaint(),
            "src/transport/paths/walk.h includes src/transport/density/gather.h: paths must not see density");
}

TEST_F(LayeringCheck, AnIntegratorIsReadWithoutThoseThatBuildOnIt) {
  write("src/integrators/path/trace.h", "");
  write("src/integrators/photonmap/photons.h", "#include \"integrators/path/trace.h\"\n");
  EXPECT_EQ(complaint(), "");
  write("src/integrators/path/trace.cpp", "#include \"integrators/photonmap/photons.h\"\n");
  EXPECT_NE(complaint().find("src/integrators/path/trace.cpp includes src/integrators/photonmap/photons.h: "
                             "path must not see photonmap"),
            std::string::npos);
}

TEST_F(LayeringCheck, FindsACrowdedFolderAndOneThatDoesNotSayWhatItIsFor) {
  for (int i = 0; i < 17; ++i) write("src/core/many/f" + std::to_string(i) + ".cpp", "");
  EXPECT_EQ(complaint(), "src/core/many has 17 files, more than 16");
  for (int i = 0; i < 2; ++i) fs::remove(root / ("src/core/many/f" + std::to_string(i) + ".cpp"));
  fs::remove(root / "src/core/many/README.md");
  EXPECT_EQ(complaint(), "src/core/many has no README.md");
}

TEST_F(LayeringCheck, FindsAFileInNoModule) {
  write("src/misc/x.cpp", "");
  write("src/x.cpp", "");
  write("include/recurse/apps/x.h", "");
  EXPECT_EQ(complaint(), "include/recurse/apps/x.h is in no module | src/misc/x.cpp is in no module | "
                         "src/x.cpp is in no module");
}

TEST_F(LayeringCheck, FindsAListThatIsIncomplete) {
  write("src/shapes/s.cpp", "void registerS(PlugIns&) {}\n");
  EXPECT_EQ(complaint(), "registerS is missing in src/plugins/list.h");
}

TEST_F(LayeringCheck, FindsPlugInsWithoutADefinitionAndWithTwo) {
  write("src/plugins/list.h",
        "RECURSE_PLUG_IN(B)\nRECURSE_PLUG_IN(I)\nRECURSE_PLUG_IN(Gone)\n// RECURSE_PLUG_IN(Comment)\n");
  write("src/bsdfs/c.cpp", "void registerB(PlugIns& other) {}\nvoid registerGone(PlugIns&);\n");
  EXPECT_EQ(complaint(), "registerB of src/plugins/list.h is defined 2 times | "
                         "registerGone of src/plugins/list.h is defined 0 times");
}

TEST_F(LayeringCheck, FindsAPlugInListedTwice) {
  write("src/plugins/list.h", "RECURSE_PLUG_IN(B)\nRECURSE_PLUG_IN(I)\nRECURSE_PLUG_IN(B)\n");
  EXPECT_EQ(complaint(), "src/plugins/list.h lists B more than once");
}
