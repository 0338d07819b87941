#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/engine/numbers.h"

namespace pavo::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// What the graph says is wrong with the pipeline that `declare` builds; "" if nothing.
template <class Declare>
std::string complaint(Declare declare) {
  SteadyClock clock;
  Pipeline<Numbers> pipeline(workers(1), clock);
  declare(pipeline);
  try {
    pipeline.prepare();
  } catch (const GraphError& e) {
    return e.what();
  }
  return "";
}

struct Copy2 {
  void operator()(const std::int64_t&, std::int64_t&) const {}
};
struct WithPrevious {
  void operator()(const std::int64_t&, const std::int64_t*, std::int64_t&) {}
  void missed(const std::int64_t*, std::int64_t&) {}
};

TEST(Graph, NamesTheReaderOfAPartThatNobodyWrites) {
  EXPECT_THAT(complaint([](auto& p) {
                p.source(writes(&Numbers::input));
                p.add("lonely", reads(&Numbers::squared), writes(&Numbers::sum), Copy2{}, parallel);
              }),
              AllOf(HasSubstr("'lonely'"), HasSubstr("no stage and no source writes"), HasSubstr("long")));
}

TEST(Graph, NamesBothWritersOfAPart) {
  EXPECT_THAT(complaint([](auto& p) {
                p.source(writes(&Numbers::input));
                p.add("one", reads(&Numbers::input), writes(&Numbers::sum), Copy2{}, parallel);
                p.add("other", reads(&Numbers::input), writes(&Numbers::sum), Copy2{}, parallel);
              }),
              AllOf(HasSubstr("'one'"), HasSubstr("'other'"), HasSubstr("written by two")));
  EXPECT_THAT(complaint([](auto& p) {
                p.source(writes(&Numbers::input));
                p.add(
                    "usurper", reads(), writes(&Numbers::input), [](std::int64_t&) {}, parallel);
              }),
              AllOf(HasSubstr("'source'"), HasSubstr("'usurper'")));
}

TEST(Graph, NamesTheStagesOfACircle) {
  EXPECT_THAT(complaint([](auto& p) {
                p.source(writes(&Numbers::input));
                p.add("fine", reads(&Numbers::input), writes(&Numbers::sum), Copy2{}, parallel);
                p.add("hen", reads(&Numbers::squared), writes(&Numbers::doubled), Copy2{}, parallel);
                p.add("egg", reads(&Numbers::doubled), writes(&Numbers::squared), Copy2{}, parallel);
              }),
              AllOf(HasSubstr("circle: 'hen', 'egg'"), testing::Not(HasSubstr("fine"))));
  EXPECT_THAT(complaint([](auto& p) {
                p.source(writes(&Numbers::input));
                p.add("self", reads(&Numbers::sum), writes(&Numbers::sum), Copy2{}, parallel);
              }),
              HasSubstr("circle: 'self'"));
}

TEST(Graph, RefusesThePreviousFrameWhereItMakesNoSense) {
  EXPECT_THAT(complaint([](auto& p) {
                p.source(writes(&Numbers::input, &Numbers::squared));
                p.add("odd", reads(&Numbers::input, previous(&Numbers::squared)), writes(&Numbers::sum), WithPrevious{},
                      in_order);
              }),
              AllOf(HasSubstr("'odd'"), HasSubstr("but not the current one's")));
}

TEST(Graph, RefusesTwoStagesOfOneName) {
  EXPECT_THAT(complaint([](auto& p) {
                p.source(writes(&Numbers::input));
                p.add("twin", reads(&Numbers::input), writes(&Numbers::sum), Copy2{}, parallel);
                p.add("twin", reads(&Numbers::input), writes(&Numbers::squared), Copy2{}, parallel);
              }),
              HasSubstr("'twin'"));
}

TEST(Graph, PutsTheNearestToTheDeliveryFirst) {
  const Part a{0, "a"}, b{8, "b"}, c{16, "c"}, d{24, "d"};
  const Graph graph = derive_graph({a}, {{.name = "late", .kind = StageKind::in_order, .reads = {b, c}, .writes = {d}},
                                         {.name = "early", .reads = {a}, .writes = {b}},
                                         {.name = "middle", .reads = {b}, .writes = {c}}});
  std::vector<std::string> names;
  for (const std::size_t n : graph.by_priority) names.push_back(graph.nodes[n].name);
  EXPECT_THAT(names, ElementsAre("delivery", "late", "middle", "early"));
  EXPECT_EQ(graph.minimum_slots, 1u);
}

TEST(Graph, KeepsASlotMoreForThePreviousFrame) {
  const Part a{0, "a"}, b{8, "b"};
  const Graph graph =
      derive_graph({a}, {{.name = "s", .kind = StageKind::in_order, .reads = {a}, .previous = {a}, .writes = {b}}});
  EXPECT_EQ(graph.minimum_slots, 2u);

  SteadyClock clock;
  PipelineOptions options = workers(1);
  options.slots = 1;
  Pipeline<Numbers> pipeline(options, clock);
  pipeline.source(writes(&Numbers::input));
  pipeline.add("s", reads(&Numbers::input, previous(&Numbers::input)), writes(&Numbers::sum), WithPrevious{}, in_order);
  EXPECT_THROW(pipeline.prepare(), std::invalid_argument);
}

TEST(Options, OutOfRangeAreToldInOneLine) {
  for (auto broken :
       {+[](PipelineOptions& o) { o.workers = 0; }, +[](PipelineOptions& o) { o.slots = 33; },
        +[](PipelineOptions& o) { o.live_credits = -1; }, +[](PipelineOptions& o) { o.failures_in_a_row = 0; }}) {
    PipelineOptions options;
    EXPECT_EQ(options.invalid(), "");
    broken(options);
    EXPECT_NE(options.invalid(), "");
  }
}

}  // namespace
}  // namespace pavo::test
