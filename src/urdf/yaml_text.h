#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

/// Values as one writes them in a model file.
namespace mimbre::urdf {

/// "[1, 0, 2.5]", with 15 digits; what is round-off beside the others, or at most `least`, is 0.
std::string numbers(const std::vector<double>& values, double least = 0);
std::string list(const Eigen::Vector3d& v, double least = 0);
/// The same of a place in m.
std::string point(const Eigen::Vector3d& p);
std::string number(double value);
/// ", x: [..], y: [..]"; empty for the global axes.
std::string axes(const Eigen::Matrix3d& rotation);
/// A word, in quotes where it must be.
std::string yaml_word(const std::string& text);
/// What can stand in a comment: one line.
std::string comment(std::string text);

}  // namespace mimbre::urdf
