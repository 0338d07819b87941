// From what each stage reads and writes to who waits for whom; everything that is wrong with it is found here, before
// the first frame.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace pavo {

/// A part of the frame: its offset is its identity, its type's name is for messages.
struct Part {
  std::size_t offset = 0;
  std::string type;
};

enum class StageKind {
  parallel,    ///< const-callable: frames may overtake each other in it
  in_order,    ///< has a state: sees every frame once, in the order of admission
  background,  ///< takes over in order what it needs, lets the frame go, and works on behind its back
};

/// What a background stage made of the frame `delay` before this one.
struct DelayedPart {
  Part part;
  int delay = 1;
};

struct StageDeclaration {
  std::string name;
  StageKind kind = StageKind::parallel;
  std::vector<Part> reads;     ///< of this frame
  std::vector<Part> previous;  ///< of the frame before; each must be read of this frame, too
  std::vector<DelayedPart> delayed;
  std::vector<Part> writes;
};

class GraphError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The checked graph. Node 0 is the source; the last node is the delivery, which waits for all but the background.
struct Graph {
  struct DelayedEdge {
    std::size_t writer;  ///< a background node
    int delay;
  };
  struct Node {
    std::string name;
    StageKind kind = StageKind::parallel;
    std::vector<std::size_t> producers;           ///< whose output it reads, each once
    std::vector<std::size_t> dependents;          ///< who reads its output
    std::vector<std::size_t> previous_producers;  ///< who wrote each part of `previous`, in declaration order
    std::vector<DelayedEdge> delayed;             ///< in declaration order
    bool reads_previous() const { return !previous_producers.empty(); }
  };
  std::vector<Node> nodes;
  std::vector<std::size_t> by_priority;  ///< the nodes but the source, the nearest to the delivery first
  std::size_t minimum_slots = 1;         ///< with fewer frames in the ring the pipeline could not move
  int buffers = 0;                       ///< of every delayed value; 0 where there is no background

  std::size_t delivery() const { return nodes.size() - 1; }
};

/// Throws GraphError, with the stages' names, for: a part that nobody writes or two write, a circle, a part read as
/// previous only, previous or delayed parts of a parallel or background stage, a background stage's part that is not
/// read delayed (or another's that is), a delayed edge that does not lead back, two stages of one name. `source_writes`
/// are what the source fills.
Graph derive_graph(const std::vector<Part>& source_writes, const std::vector<StageDeclaration>& stages);

}  // namespace pavo
