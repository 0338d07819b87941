// "Did you mean": the known word that a misspelt one is nearest to.
#pragma once

#include <span>
#include <string_view>

namespace pavo {

/// The candidate with the smallest edit distance (insert, delete, replace, swap of neighbours); the first of equal
/// ones; "" when none is within a third of the word's length (at least 2).
std::string_view nearest_word(std::string_view word, std::span<const std::string_view> candidates);

}  // namespace pavo
