#include "brim/world/number_fold.h"

#include <cmath>
#include <limits>

namespace brim {

void NumberFold::add(double x) {
  const bool first = count_++ == 0;
  const auto keep_if = [&](bool better) {
    if (first || std::isnan(x) || better) value_ = x;
  };
  if (!first && std::isnan(value_) && take_ != Take::Last) return;
  switch (take_) {
    case Take::SumAfterFirst:
      if (first) return;
      [[fallthrough]];
    case Take::Mean:
    case Take::Sum:
      value_ += x;
      return;
    case Take::Last:
      value_ = x;
      return;
    case Take::Least:
      return keep_if(x < value_);
    case Take::Largest:
      return keep_if(x > value_);
    case Take::FarthestFromOne:
      return keep_if(std::abs(x - 1.0) > std::abs(value_ - 1.0));
  }
}

double NumberFold::value() const {
  if (count_ == 0) return std::numeric_limits<double>::quiet_NaN();
  return take_ == Take::Mean ? value_ / static_cast<double>(count_) : value_;
}

}  // namespace brim
