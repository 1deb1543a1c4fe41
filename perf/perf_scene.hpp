// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_PERF_SCENE_HPP
#define OPENCV_AQORB_PERF_SCENE_HPP

#include <opencv2/core.hpp>

namespace opencv_test
{

/** A synthetic photograph: a smooth sky, houses with windows, textured ground, plain walls, blur of a
 lens and noise of a sensor. The same for every run; objects grow with the image, texture does not.
 Its FAST corners are about as many, and as unevenly spread, as a street scene's of the same size. */
cv::Mat makeStreetScene(const cv::Size& size);

}  // namespace opencv_test

#endif
