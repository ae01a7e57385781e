/** @file
 * The one cluster that the process belongs to.
 */
#include "apps/run/cluster.h"

namespace recurse::apps {

namespace {
Cluster* theCluster = nullptr;
} // namespace

Cluster* cluster() { return theCluster; }
void setCluster(Cluster* c) { theCluster = c; }

} // namespace recurse::apps
