#include "engine/graph.h"

#include <algorithm>
#include <map>
#include <set>

namespace pavo {
namespace {

using Writers = std::map<std::size_t, std::size_t>;  // offset of a part -> the node that writes it

void add_writer(Writers& writers, const Part& part, std::size_t node, const std::vector<Graph::Node>& nodes) {
  const auto [at, inserted] = writers.emplace(part.offset, node);
  if (!inserted)
    throw GraphError("the part of type " + part.type + " is written by two: '" + nodes[at->second].name + "' and '" +
                     nodes[node].name + "'");
}

std::size_t writer_of(const Writers& writers, const Part& part, const std::string& reader) {
  const auto at = writers.find(part.offset);
  if (at == writers.end())
    throw GraphError("stage '" + reader + "' reads a part of type " + part.type +
                     " that no stage and no source writes");
  return at->second;
}

void check_previous(const StageDeclaration& stage) {
  if (!stage.previous.empty() && stage.kind != StageKind::in_order)
    throw GraphError("stage '" + stage.name + "' is " +
                     (stage.kind == StageKind::parallel ? "parallel" : "background") +
                     ": only an in-order stage can read the previous frame");
  for (const Part& part : stage.previous)
    if (std::none_of(stage.reads.begin(), stage.reads.end(), [&](const Part& r) { return r.offset == part.offset; }))
      throw GraphError("stage '" + stage.name + "' reads the previous frame's " + part.type +
                       " but not the current one's: nothing would make it wait until that is written");
}

// Whether `to` waits, by whatever way, for what `from` makes of the same frame.
bool leads_to(const std::vector<Graph::Node>& nodes, std::size_t from, std::size_t to) {
  const auto& producers = nodes[to].producers;
  return std::any_of(producers.begin(), producers.end(),
                     [&](std::size_t p) { return p == from || leads_to(nodes, from, p); });
}

void check_delayed(const StageDeclaration& stage, const DelayedPart& read, std::size_t writer,
                   const std::vector<Graph::Node>& nodes) {
  if (stage.kind != StageKind::in_order)
    throw GraphError("stage '" + stage.name + "' reads " + read.part.type +
                     " delayed: only an in-order stage can do that");
  if (nodes[writer].kind != StageKind::background)
    throw GraphError("stage '" + stage.name + "' reads " + read.part.type + " delayed, but '" + nodes[writer].name +
                     "', which writes it, is not a background stage: read it plainly");
  if (read.delay < 1)
    throw GraphError("stage '" + stage.name + "' reads " + read.part.type + " with a delay of " +
                     std::to_string(read.delay) + ": expected at least 1");
}

void check_plain(const StageDeclaration& stage, const Part& part, std::size_t writer,
                 const std::vector<Graph::Node>& nodes) {
  if (nodes[writer].kind == StageKind::background)
    throw GraphError("stage '" + stage.name + "' reads " + part.type + " of the background stage '" +
                     nodes[writer].name + "': that is there only later, read it with delayed<>()");
}

// A value that does not flow back could be waited for, and the wait for it would have no end to hold on to.
void check_delayed_lead_back(const std::vector<Graph::Node>& nodes) {
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (const Graph::DelayedEdge& edge : nodes[n].delayed)
      if (!leads_to(nodes, n, edge.writer))
        throw GraphError("stage '" + nodes[n].name + "' reads what '" + nodes[edge.writer].name +
                         "' made of an earlier frame, but '" + nodes[edge.writer].name +
                         "' does not read, by whatever way, what '" + nodes[n].name +
                         "' writes: a delayed edge leads back only");
}

// Kahn's algorithm; what is left over stands in a circle.
std::vector<std::size_t> topological_order(const std::vector<Graph::Node>& nodes) {
  std::vector<std::size_t> missing(nodes.size()), order;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    missing[n] = nodes[n].producers.size();
    if (missing[n] == 0) order.push_back(n);
  }
  for (std::size_t i = 0; i < order.size(); ++i)
    for (const std::size_t d : nodes[order[i]].dependents)
      if (--missing[d] == 0) order.push_back(d);
  if (order.size() == nodes.size()) return order;
  std::string names;
  for (std::size_t n = 0; n + 1 < nodes.size(); ++n)  // the delivery, which waits for all, is not part of the circle
    if (missing[n] > 0) names += (names.empty() ? "'" : ", '") + nodes[n].name + "'";
  throw GraphError("these stages wait for each other in a circle: " + names);
}

// The nearest to the delivery first: by the longest way to it, and among equals the one declared last.
std::vector<std::size_t> priorities(const std::vector<Graph::Node>& nodes, const std::vector<std::size_t>& order) {
  std::vector<int> distance(nodes.size(), 0);
  for (auto n = order.rbegin(); n != order.rend(); ++n)
    for (const std::size_t d : nodes[*n].dependents) distance[*n] = std::max(distance[*n], distance[d] + 1);
  std::vector<std::size_t> sorted;
  for (std::size_t n = nodes.size(); n-- > 1;) sorted.push_back(n);
  std::stable_sort(sorted.begin(), sorted.end(), [&](auto a, auto b) { return distance[a] < distance[b]; });
  return sorted;
}

// How many frames and delayed values must be there at once.
void count_memory(Graph& graph) {
  int delay = 0, readers = 0;
  bool keeps_previous = false, background = false;
  for (const Graph::Node& node : graph.nodes) {
    keeps_previous |= node.reads_previous();
    background |= node.kind == StageKind::background;
    for (const Graph::DelayedEdge& edge : node.delayed) delay = std::max(delay, edge.delay);
    readers += static_cast<int>(node.delayed.size());
  }
  // Exact: the values of the last `delay` frames, and two of grace. Live: what each reader holds, the newest, and the
  // one that is being written.
  if (background) graph.buffers = std::max(delay, readers) + 2;
  graph.minimum_slots = keeps_previous ? 2 : 1;  // frame k-1 is kept while k passes through
  // A value is announced to the slot of the frame that waits for it: one that its reader has passed by then.
  graph.minimum_slots = std::max(graph.minimum_slots, static_cast<std::size_t>(graph.buffers));
}

}  // namespace

Graph derive_graph(const std::vector<Part>& source_writes, const std::vector<StageDeclaration>& stages) {
  Graph graph;
  graph.nodes.push_back({.name = "source", .kind = StageKind::in_order});
  std::set<std::string> names{"source", "delivery"};
  for (const StageDeclaration& stage : stages) {
    if (!names.insert(stage.name).second) throw GraphError("two stages are named '" + stage.name + "'");
    check_previous(stage);
    graph.nodes.push_back({.name = stage.name, .kind = stage.kind});
  }

  Writers writers;
  for (const Part& part : source_writes) add_writer(writers, part, 0, graph.nodes);
  for (std::size_t s = 0; s < stages.size(); ++s)
    for (const Part& part : stages[s].writes) add_writer(writers, part, s + 1, graph.nodes);

  for (std::size_t s = 0; s < stages.size(); ++s) {
    std::set<std::size_t> producers;
    for (const Part& part : stages[s].reads) {
      producers.insert(writer_of(writers, part, stages[s].name));
      check_plain(stages[s], part, writer_of(writers, part, stages[s].name), graph.nodes);
    }
    if (producers.empty()) producers.insert(0);  // a stage without input still runs once a frame
    graph.nodes[s + 1].producers.assign(producers.begin(), producers.end());
    for (const Part& part : stages[s].previous)
      graph.nodes[s + 1].previous_producers.push_back(writer_of(writers, part, stages[s].name));
    for (const DelayedPart& read : stages[s].delayed) {
      const std::size_t writer = writer_of(writers, read.part, stages[s].name);
      check_delayed(stages[s], read, writer, graph.nodes);
      graph.nodes[s + 1].delayed.push_back({writer, read.delay});
    }
  }

  Graph::Node delivery{.name = "delivery", .kind = StageKind::in_order};
  for (std::size_t n = 0; n < graph.nodes.size(); ++n)
    if (graph.nodes[n].kind != StageKind::background) delivery.producers.push_back(n);
  graph.nodes.push_back(delivery);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n)
    for (const std::size_t p : graph.nodes[n].producers) graph.nodes[p].dependents.push_back(n);

  graph.by_priority = priorities(graph.nodes, topological_order(graph.nodes));
  check_delayed_lead_back(graph.nodes);
  count_memory(graph);
  return graph;
}

}  // namespace pavo
