#pragma once
/// Names that rules use, and help where one is misspelt.

#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace ballbar {

/// Labels of a Record as rules see them, beside its quantities.
const std::vector<std::string_view>& label_names();

bool is_label(std::string_view name);

/// What a rule may be on; also Record::kind.
const std::vector<std::string>& subjects();

/// The quantities of a subject that are not in the catalogue, and those of it that "test" has; others: none.
std::vector<std::string> own_quantities(const std::string& kind);

/// True for quantities of records of `kind` (one of subjects()), harmonics included.
bool is_quantity_of(std::string_view name, std::string_view kind);

/// The label as text ("+1" for a direction); empty where `name` is none.
std::string label_text(const Record& record, std::string_view name);

/// The one of `known` that is nearest to `name` by edit distance, at most `most` away; empty where none is.
std::string nearest(std::string_view name, const std::vector<std::string_view>& known, std::size_t most);

/// "; did you mean 'ovality_um'?" with the nearest of the labels and quantities of `kind` and of `more`, or
/// "".
std::string suggestion(std::string_view name, std::string_view kind,
                       const std::vector<std::string_view>& more = {});

/// "; did you mean 'word'?" or, where `word` is empty, "".
std::string did_you_mean(const std::string& word);

/// The lines (from 1) of Lua text on which `word` stands as a whole word, comments left out; a line once for
/// each time.
std::vector<int> lines_with(std::string_view source, std::string_view word);

/// The first of lines_with, or 0.
int line_of(std::string_view source, std::string_view word);

/// The line of the file's own `return`: the first that stands at the left edge. 0 where there is none.
int line_of_return(std::string_view source);

}  // namespace ballbar
