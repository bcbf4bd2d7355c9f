#pragma once

#include "regraft/kdtree/origin_space.h"

namespace regraft::kdtree {

/// p_N exactly (Fabianowski et al. 2009, eq. 3). The paper calls the integral elliptic; it is
/// elementary: seen from outside, the faces of N do not overlap, so their solid angles are summed
/// face by face over the part of S beyond each; integrating h/r³ across that part leaves 1/r
/// between two parallel rectangles. Error about 1e-16, so relative to a tiny p_N large: there
/// Gauss points on the faces replace the outer integral.
double exact_probability(const OriginSpace& space);

/// p_N with every face of N represented by `points`² Gauss points (1 or 2), each seen exactly
/// over S.
double face_probability(const OriginSpace& space, int points);

}  // namespace regraft::kdtree
