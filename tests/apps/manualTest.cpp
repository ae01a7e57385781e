/** @file
 * Manual pages and completions contain every subcommand and option of --help.
 */
#include "program.h"

#include <set>
#include <sstream>

using namespace programTesting;

namespace {

class Manual : public Program {
 protected:
  static std::set<std::string> optionsIn(const std::string& help) {
    std::set<std::string> out;
    for (size_t at = 0; (at = help.find("--", at)) != std::string::npos;) {
      const size_t end = help.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", at);
      const std::string name = help.substr(at, end - at);
      if (at >= 2 && (help[at - 1] == ',' || (help[at - 1] == ' ' && help[at - 2] == ' '))) out.insert(name);
      at = end;
    }
    return out;
  }
  /** Text as displayed: troff source has a backslash before every dash. */
  static std::string withoutBackslashes(std::string text) {
    std::erase(text, '\\');
    return text;
  }
};

} // namespace

TEST_F(Manual, HasWhatHelpHas) {
  const std::string completions = run({"--completion", "bash"}).out, zsh = run({"--completion", "zsh"}).out,
                    fish = run({"--completion", "fish"}).out;
  for (const std::string command : {"render", "split", "merge", "compare", "converge", "reference"}) {
    const std::set<std::string> options = optionsIn(run({command, "--help"}).out);
    EXPECT_GE(options.size(), 2u);
    const Outcome page = run({"--manual", command});
    ASSERT_EQ(page.status, 0) << page.err;
    EXPECT_TRUE(page.out.starts_with(".TH recurse-" + command));
    const std::string text = withoutBackslashes(page.out);
    for (const std::string& option : options) {
      EXPECT_TRUE(has(text, option)) << command << " " << option;
      EXPECT_TRUE(has(completions, option) && has(zsh, option) && has(fish, "-l " + option.substr(2)))
          << command << " " << option;
    }
    EXPECT_TRUE(has(run({"--manual", "recurse"}).out, ".B " + command));
  }
  EXPECT_EQ(run({"--manual", "nothing"}).status, 2);
  EXPECT_EQ(run({"--completion", "csh"}).status, 2);
  EXPECT_EQ(run({}).status, 0); // a quick start
}

TEST_F(Manual, BashCompletes) {
  write("c.bash", run({"--completion", "bash"}).out);
  const auto completed = [&](const std::string& words, const std::string& at) {
    const std::string command = "cd " + folder + " && bash -c 'source ./c.bash && COMP_WORDS=(" + words +
                                ") COMP_CWORD=" + at + " && _recurse && echo ${COMPREPLY[*]}' >done";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return contents(file("done"));
  };
  EXPECT_EQ(completed("recurse re", "1"), "render reference\n");
  EXPECT_EQ(completed("recurse render --check", "2"), "--checkpoint --checkpoint-interval --check\n");
  EXPECT_EQ(completed("recurse render --progress p", "3"), "plain\n");
}
