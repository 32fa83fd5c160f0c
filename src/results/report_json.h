#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mimbre/report.h"

/// What the data of a page are made of; web/src/data.ts reads it.
namespace mimbre::results {

using Json = nlohmann::ordered_json;

/// Arrays as base64 of little-endian numbers.
Json array_of(const std::vector<float>& values);
Json array_of(const std::vector<double>& values);
Json array_of(const std::vector<std::uint32_t>& values);

/// How a record is thinned. One that is too long is cut into stretches of `2·half` instants; each leaves its
/// smallest and largest value, in their order.
struct Samples {
  Eigen::Index count = 0;
  Eigen::Index half = 1;  ///< instants per kept sample
};
/// At most `most` samples (and at least 2) of `count` instants.
Samples sampling(Eigen::Index count, Eigen::Index most);
std::vector<double> sample_times(const Eigen::VectorXd& time, const Samples& samples);
/// Values less `offset`, for which single precision is enough then.
void append_samples(const Eigen::Ref<const Eigen::VectorXd>& values, double offset, const Samples& samples,
                    std::vector<float>& out);

/// The median of the finite values; 0 where there is none. What is left after subtracting it keeps seven
/// digits of the channel's range, and near it more: a run that ends with absurd values leaves the sound ones
/// readable.
double typical(const Eigen::Ref<const Eigen::VectorXd>& values);

/// Throws InputError when the parts of the results contradict each other.
void check_sizes(const Results& results);

/// Throws InputError when frames or elements are on what is not there.
void check_elements(const ResultsHeader& header);

/// Throws InputError when the parts of the drawing contradict each other.
void check_drawing(const BodyDrawing& body);

/// At most `most` points, see thin_surface; those where the modes' stresses are largest are kept.
Json body_json(const BodyDrawing& body, int most);

/// How many points of each body a page can carry.
int drawn_points(const std::vector<BodyDrawing>& bodies);

/// What is animated: bodies, roads, and the motion of at most `max_frames` instants.
Json scene_json(const Results& results, int max_frames);

/// Joints, springs, loads and tyres, and the frames that they are at.
Json elements_json(const ResultsHeader& header);

/// The channels with angles that jump between −π and π made continuous; other columns as they are.
Eigen::MatrixXd continuous_channels(const Results& results);

/// JSON text as JSON, keys in their order; what cannot be read is shown as it is, no text is null.
Json parsed(const std::string& text);

/// Places in `channels` of the names that the options ask for. Throws InputError for one that is not there.
Json shown_channels(const std::vector<ChannelInfo>& channels, const ReportOptions& options);

}  // namespace mimbre::results
