/** @file
 * The flag that work in progress asks.
 */
#include "recurse/core/threads/interrupt.h"

namespace recurse {

Interrupted::Interrupted()
    : Error("interrupted before the first sample: nothing is written", ExitStatus::INTERRUPTED) {}

} // namespace recurse
