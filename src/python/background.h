/** @file
 * Rendering in a background thread, so that other Python threads run and Ctrl-C works.
 */
#pragma once

#include <functional>

namespace recurse::python {

/**
 * Runs `work` in a thread of its own, without the GIL, and waits for it. Ten times a second, `look` is called
 * with the GIL, in the calling thread. If `look` throws, or on Ctrl-C, checkInterrupted() throws in the work,
 * `stop` is called, and the exception is thrown after the work has ended. Exceptions of `work` are thrown,
 * too.
 */
void runInBackground(const std::function<void()>& work, const std::function<void()>& look,
                     const std::function<void()>& stop);

} // namespace recurse::python
