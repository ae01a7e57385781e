/** @file
 * Sum of the films of all ranks.
 */
#pragma once

#include <cstddef>
#include <vector>

#include <mpi.h>

#include "recurse/model/film/film.h"

namespace recurse::apps {

/** Adds up the films of all ranks at the leader, in the background. */
class FilmReduction {
 public:
  explicit FilmReduction(Film& shape);
  ~FilmReduction();
  FilmReduction(const FilmReduction&) = delete;
  FilmReduction& operator=(const FilmReduction&) = delete;

  /** `sum`: target at the leader; null at all other ranks. Both films must exist until it has ended. */
  void start(Film& own, Film* sum);
  bool isActive() const { return active; }
  /** True once, after the reduction has ended. */
  bool ended();

 private:
  std::vector<MPI_Datatype> types;
  std::vector<MPI_Op> operations;
  std::vector<MPI_Request> requests;
  bool active = false;
};

} // namespace recurse::apps
