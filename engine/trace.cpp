#include "engine/trace.h"

#include <pthread.h>
#include <unistd.h>

#include <cerrno>
#include <cinttypes>
#include <cstdarg>
#include <cstring>
#include <stdexcept>

#include "engine/clock.h"

namespace pavo {
namespace {

constexpr std::size_t kEventsPerThread = 4096;
constexpr std::int64_t kPeriod_ns = 50'000'000;

double us(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-3;
}

// Names are the program's own, but a quotation mark in one would break the file.
std::string quoted(const std::string& name) {
  std::string result;
  for (const char c : name) {
    if (c == '"' || c == '\\') result += '\\';
    result += c < ' ' ? '?' : c;
  }
  return result;
}

const char* word(TraceEvent::Kind kind) {
  switch (kind) {
    case TraceEvent::Kind::failed:
      return "failed";
    case TraceEvent::Kind::missed:
      return "missed";
    case TraceEvent::Kind::late:
      return "late";
    default:
      return "ok";
  }
}

}  // namespace

Trace::Trace(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "we")) {
  if (!file_)
    throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno) +
                             "; expected a file name in a folder that is there");
}

Trace::~Trace() {
  try {
    finish();
  } catch (const std::exception&) {  // who wants to know calls finish()
  }
}

void Trace::start(std::vector<std::string> threads, std::vector<std::string> nodes,
                  std::vector<std::string> drop_reasons) {
  threads_ = std::move(threads);
  nodes_ = std::move(nodes);
  drop_reasons_ = std::move(drop_reasons);
  for (std::vector<std::string>* names : {&threads_, &nodes_, &drop_reasons_})
    for (std::string& name : *names) name = quoted(name);
  for (std::size_t t = 0; t < threads_.size(); ++t)
    rings_.push_back(std::make_unique<EventRing<TraceEvent>>(kEventsPerThread));
  std::fputs("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n", file_);
  write_names();
  writer_ = std::jthread([this] { write_while_open(); });
}

void Trace::finish() {
  if (!file_) return;
  if (writer_.joinable()) {
    ended_ = true;
    end_there_.notify_all();
    writer_.join();
    write_all();
    std::fprintf(file_, "\n],\"otherData\":{\"lost_events\":%" PRIu64 "}}\n", lost());
  } else {
    std::fputs("{\"traceEvents\":[]}\n", file_);
  }
  failed_ |= std::ferror(file_) != 0;
  failed_ |= std::fclose(file_) != 0;
  file_ = nullptr;
  if (failed_) throw std::runtime_error(path_ + ": could not be written to the end: is the disk full?");
}

std::uint64_t Trace::lost() const {
  std::uint64_t lost = 0;
  for (const auto& ring : rings_) lost += ring->lost();
  return lost;
}

void Trace::write_while_open() {
  pthread_setname_np(pthread_self(), "pavo-trace");
  SteadyClock clock;
  while (!ended_.load()) {
    const EventCount::Key key = end_there_.prepare();
    if (ended_.load())
      end_there_.cancel();
    else
      clock.wait(end_there_, key, clock.now_ns() + kPeriod_ns);
    write_all();
  }
}

void Trace::write_all() {
  for (std::size_t t = 0; t < rings_.size(); ++t)
    rings_[t]->drain([&](const TraceEvent& event) { write(static_cast<int>(t), event); });
  std::fflush(file_);
}

void Trace::line(const char* format, ...) {
  if (!first_) std::fputs(",\n", file_);
  first_ = false;
  va_list arguments;
  va_start(arguments, format);
  std::vfprintf(file_, format, arguments);
  va_end(arguments);
}

void Trace::write_names() {
  const int pid = getpid();
  line(R"({"ph":"M","name":"process_name","pid":%d,"tid":0,"args":{"name":"pavo"}})", pid);
  for (std::size_t t = 0; t < threads_.size(); ++t) {
    line(R"({"ph":"M","name":"thread_name","pid":%d,"tid":%zu,"args":{"name":"%s"}})", pid, t, threads_[t].c_str());
    line(R"({"ph":"M","name":"thread_sort_index","pid":%d,"tid":%zu,"args":{"sort_index":%zu}})", pid, t, t);
  }
}

void Trace::write(int thread, const TraceEvent& e) {
  const int pid = getpid();
  const double start = us(e.t_start_ns);
  if (e.kind == TraceEvent::Kind::dropped) {
    line(R"({"ph":"i","s":"t","cat":"drop","name":"dropped: %s","pid":%d,"tid":%d,"ts":%.3f})",
         drop_reasons_[e.node].c_str(), pid, thread, start);
    return;
  }
  const bool first = e.node == 0;
  line(R"({"ph":"X","cat":"stage","name":"%s","pid":%d,"tid":%d,"ts":%.3f,"dur":%.3f,)"
       R"("args":{"frame":%)" PRIu64 R"(,"wait_us":%.3f,"outcome":"%s"}})",
       nodes_[e.node].c_str(), pid, thread, start, us(e.t_end_ns - e.t_start_ns), e.sequence, us(e.wait_ns),
       word(e.kind));
  // An arrow binds to the slice that is open on this row at its time. It is never ended ("f"): a background stage works
  // on a frame after its delivery.
  line(R"({"ph":"%s","cat":"frame","name":"frame","id":%)" PRIu64 R"(,"pid":%d,"tid":%d,"ts":%.3f})", first ? "s" : "t",
       e.sequence, pid, thread, start);
  if (first)
    line(R"({"ph":"C","name":"frames in flight","pid":%d,"tid":0,"ts":%.3f,"args":{"frames":%u}})", pid, us(e.t_end_ns),
         static_cast<unsigned>(e.in_flight));
}

}  // namespace pavo
