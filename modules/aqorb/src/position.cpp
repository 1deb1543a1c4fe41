// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "precomp.hpp"

#include "fast.hpp"
#include "position.hpp"

namespace cv
{
namespace aqorb
{
namespace stages
{

Point2f PositionMap::operator()(int x, int y, double dx, double dy) const
{
    if (!subPixel)
        return Point2f(float(x) * scale, float(y) * scale);

    struct Axis
    {
        static float map(int pixel, double offset, int imageLength, int levelLength, double scale, int border)
        {
            double position = (pixel + offset + 0.5) * imageLength / levelLength - 0.5;
            // cv::ORB::compute drops keypoints near the border. Whether it rounds positions before differs between
            // versions of OpenCV, so positions stay off the border in both cases.
            const double last = imageLength - border - 0.51;
            position = std::max(std::min(position, last), double(border));
            // The descriptor is taken at the pixel that position / scale rounds to. It must be the pixel given.
            return float(std::max(std::min(position, (pixel + 0.49) * scale), (pixel - 0.49) * scale));
        }
    };
    return Point2f(Axis::map(x, dx, imageSize.width, levelSize.width, scale, border),
                   Axis::map(y, dy, imageSize.height, levelSize.height, scale, border));
}

void maskPositions(const Mat& imageMask, const PositionMap& position, Mat& levelMask)
{
    std::vector<int> columns(levelMask.cols);
    for (int x = 0; x < levelMask.cols; x++)
        columns[x] = std::min(std::max(cvRound(position(x, 0).x), 0), imageMask.cols - 1);
    for (int y = 0; y < levelMask.rows; y++)
    {
        const uchar* use =
            imageMask.ptr(std::min(std::max(cvRound(position(0, y).y), 0), imageMask.rows - 1));
        uchar* out = levelMask.ptr(y);
        for (int x = 0; x < levelMask.cols; x++)
        {
            if (!use[columns[x]])
                out[x] = 0;
        }
    }
}

Point2d subPixelOffset(const Mat& image, int x, int y)
{
    int s[3][3];
    cornerScores3x3(image, x, y, s);

    // Derivatives by central differences. As whole numbers they are twice the gradient and four times dxy.
    const int gx2 = s[1][2] - s[1][0], gy2 = s[2][1] - s[0][1];
    const int dxx = s[1][2] - 2 * s[1][1] + s[1][0], dyy = s[2][1] - 2 * s[1][1] + s[0][1];
    const int dxy4 = s[2][2] - s[2][0] - s[0][2] + s[0][0];
    const int determinant16 = 16 * dxx * dyy - dxy4 * dxy4;
    if (dxx >= 0 || determinant16 <= 0)  // no peak
        return Point2d(0, 0);
    // The peak is at minus the inverse of the Hessian times the gradient.
    const double px = 2. * (dxy4 * gy2 - 4 * dyy * gx2) / determinant16;
    const double py = 2. * (dxy4 * gx2 - 4 * dxx * gy2) / determinant16;
    return Point2d(std::min(std::max(px, -0.5), 0.5), std::min(std::max(py, -0.5), 0.5));
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv
