// Which SIMD instructions the stages use.
#pragma once

#include <string>

namespace pavo {

/// Highway's name of the target that the stages dispatch to on this machine: "AVX3_DL", "AVX2", "SSE4", ...
std::string simd_target();

/// Makes `name` ("auto": the best) the target for the whole process. Call it before any stage runs. Throws
/// std::runtime_error, listing what there is, when this machine or this build does not have it.
void force_simd(const std::string& name);

}  // namespace pavo
