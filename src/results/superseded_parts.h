#pragma once
#include <string>

/// Killed runs leave the files that they were growing beside their targets. Once a later run to the same
/// target is whole those go of which nothing is lost; what is the end of a failed or interrupted run, of
/// which was reported to the user, stays.
namespace mimbre::results {

/// Tables with which the whole one begins. Never throws.
void remove_superseded_tables(const std::string& target) noexcept;

/// Results of the same model and the same options, cut short: the whole ones have their rows. Never throws.
void remove_superseded_results(const std::string& target, const std::string& model_text,
                               const std::string& options_json) noexcept;

}  // namespace mimbre::results
