// Compiled by scripts/build-times to tell how fast a machine compiles: what a cold unit of this project
// compiles, too.
#include <Eigen/Dense>
#include <functional>
#include <map>
#include <string>
#include <vector>

double least_of(const Eigen::MatrixXd& a, std::map<std::string, std::vector<double>>& named,
                const std::function<double(double)>& f) {
  const Eigen::LDLT<Eigen::MatrixXd> factor(a);
  for (auto& [name, values] : named)
    for (double& value : values) value = f(value) + factor.vectorD()[0];
  return (factor.solve(a) - a).cwiseAbs().minCoeff();
}
