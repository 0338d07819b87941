// What a thread may ask of the system to run when it is due. Each is asked politely: where the system refuses, the
// answer is one line that says so and what would help, and the run goes on.
#pragma once

#include <string>
#include <vector>

namespace pavo {

/// "" or why not. Of the calling thread.
std::string pin_this_thread(int cpu);
std::string make_this_thread_fifo(int priority);
/// Undoes make_this_thread_fifo().
void make_this_thread_ordinary();
/// Of the whole process, what is mapped and what will be: no page is fetched from disk, none is made at first touch.
std::string lock_all_memory();

}  // namespace pavo
