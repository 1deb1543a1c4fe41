// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#include "plain_reference.hpp"

#include <map>
#include <tuple>

namespace opencv_test
{

using aqorb::stages::LeafPoint;

ReferenceParameters::ReferenceParameters(const AdaptiveQuadtreeORB& detector)
    : nfeatures(detector.getMaxFeatures()),
      scaleFactor(detector.getScaleFactor()),
      nlevels(detector.getNLevels()),
      edgeThreshold(detector.getEdgeThreshold()),
      firstLevel(detector.getFirstLevel()),
      WTA_K(detector.getWTA_K()),
      isHarris(detector.getScoreType() == ORB::HARRIS_SCORE),
      patchSize(detector.getPatchSize()),
      fastThreshold(detector.getFastThreshold()),
      adaptiveThreshold(detector.getAdaptiveThreshold()),
      minThresholdRatio(detector.getMinThresholdRatio()),
      cellSize(detector.getCellSize()),
      maxDepth(detector.getMaxDepth()),
      octaveSuppression(detector.getOctaveSuppression()),
      subPixel(detector.getSubPixel())
{
}

int reflectedPixel(const Mat& image, int x, int y)
{
    return image.at<uchar>(borderInterpolate(y, image.rows, BORDER_REFLECT_101),
                           borderInterpolate(x, image.cols, BORDER_REFLECT_101));
}

int referenceScore(const Mat& image, Point p)
{
    const int circle[16][2] = {{0, 3},  {1, 3},   {2, 2},   {3, 1},   {3, 0},  {3, -1}, {2, -2}, {1, -3},
                               {0, -3}, {-1, -3}, {-2, -2}, {-3, -1}, {-3, 0}, {-3, 1}, {-2, 2}, {-1, 3}};
    const int center = reflectedPixel(image, p.x, p.y);
    int best = -255;
    for (int first = 0; first < 16; first++)
    {
        int brighter = 255, darker = 255;
        for (int i = 0; i < 9; i++)
        {
            const int* offset = circle[(first + i) % 16];
            const int difference = reflectedPixel(image, p.x + offset[0], p.y + offset[1]) - center;
            brighter = std::min(brighter, difference);
            darker = std::min(darker, -difference);
        }
        best = std::max(best, std::max(brighter, darker));
    }
    return best;
}

float referenceBlur(const Mat& image, Point p)
{
    const Mat kernel = getGaussianKernel(7, 2, CV_32F);
    float rows[7];
    for (int i = 0; i < 7; i++)
    {
        rows[i] = kernel.at<float>(0) * float(reflectedPixel(image, p.x - 3, p.y + i - 3));
        for (int j = 1; j < 7; j++)
        {
            const float pixel = float(reflectedPixel(image, p.x + j - 3, p.y + i - 3));
            rows[i] = std::fma(kernel.at<float>(j), pixel, rows[i]);
        }
    }
    float sum = kernel.at<float>(3) * rows[3];
    for (int i = 1; i <= 3; i++)
        sum = std::fma(rows[3 + i] + rows[3 - i], kernel.at<float>(3 + i), sum);
    return sum;
}

float referenceHarris(const Mat& image, int x, int y)
{
    int a = 0, b = 0, c = 0;
    for (int dy = -2; dy <= 2; dy++)
    {
        for (int dx = -2; dx <= 2; dx++)
        {
            int Ix = 0, Iy = 0;
            for (int i = -1; i <= 1; i++)
            {
                const int weight = i == 0 ? 2 : 1;
                Ix += weight * (reflectedPixel(image, x + dx + 1, y + dy + i) -
                                reflectedPixel(image, x + dx - 1, y + dy + i));
                Iy += weight * (reflectedPixel(image, x + dx + i, y + dy + 1) -
                                reflectedPixel(image, x + dx + i, y + dy - 1));
            }
            a += Ix * Ix;
            b += Iy * Iy;
            c += Ix * Iy;
        }
    }
    const float scale = 1.f / ((1 << 2) * 5 * 255.f);
    const float scale4 = scale * scale * scale * scale;
    return ((float)a * b - (float)c * c - 0.04f * ((float)a + b) * ((float)a + b)) * scale4;
}

float referenceAngle(const Mat& image, int x, int y, int patchSize)
{
    // cv::ORB's circle, made symmetric as there
    const int half = patchSize / 2;
    std::vector<int> umax(half + 2);
    const int vmax = cvFloor(half * std::sqrt(2.f) / 2 + 1), vmin = cvCeil(half * std::sqrt(2.f) / 2);
    for (int v = 0; v <= vmax; v++)
        umax[v] = cvRound(std::sqrt((double)half * half - v * v));
    for (int v = half, v0 = 0; v >= vmin; v--)
    {
        while (umax[v0] == umax[v0 + 1])
            v0++;
        umax[v] = v0++;
    }
    umax[0] = half;
    int m01 = 0, m10 = 0;
    for (int v = -half; v <= half; v++)
    {
        for (int u = -umax[std::abs(v)]; u <= umax[std::abs(v)]; u++)
        {
            m10 += u * reflectedPixel(image, x + u, y + v);
            m01 += v * reflectedPixel(image, x + u, y + v);
        }
    }
    return fastAtan2((float)m01, (float)m10);
}

std::vector<int> referenceSequence(const std::vector<LeafPoint>& points, int depth)
{
    typedef std::tuple<bool, float, float, float, int> Rank;  // lower is better
    struct Local
    {
        static Rank rank(const LeafPoint& p)
        {
            const bool isNaN = cvIsNaN(p.response) != 0;
            return Rank(isNaN, isNaN ? 0 : -p.response, p.y, p.x, p.index);
        }
        // The place of each point among those of the same group, by (key, rank).
        static std::vector<int> places(const std::vector<LeafPoint>& all, const std::vector<unsigned>& groups,
                                       const std::vector<int>& keys)
        {
            std::vector<int> result(all.size(), 0);
            for (size_t i = 0; i < all.size(); i++)
            {
                for (size_t j = 0; j < all.size(); j++)
                {
                    if (groups[i] == groups[j] &&
                        std::make_pair(keys[j], rank(all[j])) < std::make_pair(keys[i], rank(all[i])))
                        result[i]++;
                }
            }
            return result;
        }
    };
    std::vector<unsigned> leaves, ancestors, whole(points.size(), 0);
    for (size_t i = 0; i < points.size(); i++)
    {
        leaves.push_back(points[i].leaf);
        ancestors.push_back(depth >= 2 ? points[i].leaf / 16 : 0);
    }
    const std::vector<int> inLeaf = Local::places(points, leaves, std::vector<int>(points.size(), 0));
    const std::vector<int> inGroup = Local::places(points, ancestors, inLeaf);
    const std::vector<int> inTree = Local::places(points, whole, inGroup);
    std::vector<int> sequence(points.size());
    for (size_t i = 0; i < points.size(); i++)
        sequence[inTree[i]] = points[i].index;
    return sequence;
}

namespace
{

struct RefCorner
{
    int x, y, score;
    float response;
};
typedef std::vector<RefCorner> RefCorners;

struct RefLevel
{
    Mat image;
    float scale;
    int quota, depth;
    RefCorners kept, fallen, rejects;
    std::vector<int> chosen;                // of all, in the order of choice
    RefCorners all;                         // kept, then fallen, then rejects
    std::vector<int> sequence, passedOver;  // of kept
    size_t next;
    bool begun;
};

// The source pixels with a weight, by INTER_LINEAR_EXACT.
std::vector<int> taps(int i, int length, int sourceLength)
{
    const double inverse = (double)length / sourceLength;
    const double center = (1.0 / inverse) * (i + 0.5) - 0.5;
    const int first = cvFloor(center);
    std::vector<int> result;
    if (first < 0 || sourceLength == 1)
        result.push_back(0);
    else if (first >= sourceLength - 1)
        result.push_back(sourceLength - 1);
    else
    {
        const int weight = cvRound((center - first) * 256);
        if (weight < 256)
            result.push_back(first);
        if (weight > 0)
            result.push_back(first + 1);
    }
    return result;
}

Mat reducedMask(const Mat& mask, Size size)
{
    Mat reduced(size, CV_8UC1);
    for (int y = 0; y < size.height; y++)
    {
        for (int x = 0; x < size.width; x++)
        {
            uchar usable = 255;
            for (int sy : taps(y, size.height, mask.rows))
            {
                for (int sx : taps(x, size.width, mask.cols))
                    usable = mask.at<uchar>(sy, sx) ? usable : 0;
            }
            reduced.at<uchar>(y, x) = usable;
        }
    }
    return reduced;
}

Point2f positionOf(Size image, const RefLevel& level, int border, bool subPixel, int x, int y, double dx,
                   double dy)
{
    if (!subPixel)
        return Point2f((float)x * level.scale, (float)y * level.scale);
    const int pixel[2] = {x, y}, lengths[2] = {image.width, image.height},
              levelLengths[2] = {level.image.cols, level.image.rows};
    const double offset[2] = {dx, dy};
    float result[2];
    for (int i = 0; i < 2; i++)
    {
        double p = (pixel[i] + offset[i] + 0.5) * lengths[i] / levelLengths[i] - 0.5;
        p = std::min(p, lengths[i] - border - 0.51);
        p = std::max(p, (double)border);
        p = std::min(p, (pixel[i] + 0.49) * level.scale);
        p = std::max(p, (pixel[i] - 0.49) * level.scale);
        result[i] = (float)p;
    }
    return Point2f(result[0], result[1]);
}

Point2d peakOf(const Mat& image, int x, int y)
{
    int s[3][3];
    for (int dy = 0; dy < 3; dy++)
        for (int dx = 0; dx < 3; dx++)
            s[dy][dx] = referenceScore(image, Point(x + dx - 1, y + dy - 1));
    const int dxx = s[1][2] - 2 * s[1][1] + s[1][0], dyy = s[2][1] - 2 * s[1][1] + s[0][1];
    const int dxy4 = s[2][2] - s[2][0] - s[0][2] + s[0][0];
    const int gx2 = s[1][2] - s[1][0], gy2 = s[2][1] - s[0][1];
    const int determinant16 = 16 * dxx * dyy - dxy4 * dxy4;
    if (dxx >= 0 || determinant16 <= 0)
        return Point2d(0, 0);
    const double px = 2. * (dxy4 * gy2 - 4 * dyy * gx2) / determinant16;
    const double py = 2. * (dxy4 * gx2 - 4 * dxx * gy2) / determinant16;
    return Point2d(std::max(-0.5, std::min(0.5, px)), std::max(-0.5, std::min(0.5, py)));
}

void findCorners(const Mat& image, const Mat& mask, int iniT, int minT, const ReferenceParameters& p,
                 RefLevel& level)
{
    Mat scores(image.size(), CV_32SC1, Scalar(-1));  // cv::FAST's response
    for (int y = 3; y < image.rows - 3; y++)
        for (int x = 3; x < image.cols - 3; x++)
            scores.at<int>(y, x) = referenceScore(image, Point(x, y)) - 1;
    const int edge = p.edgeThreshold;
    RefCorners corners;
    for (int y = std::max(3, edge); y < image.rows - std::max(3, edge); y++)
    {
        for (int x = std::max(3, edge); x < image.cols - std::max(3, edge); x++)
        {
            const int score = scores.at<int>(y, x);
            bool highest = score >= minT;
            for (int dy = -1; dy <= 1; dy++)
                for (int dx = -1; dx <= 1; dx++)
                    highest = highest && (score > scores.at<int>(y + dy, x + dx) || (dx == 0 && dy == 0));
            if (highest && (mask.empty() || mask.at<uchar>(y, x)))
            {
                const RefCorner corner = {x, y, score,
                                          p.isHarris ? referenceHarris(image, x, y) : (float)score};
                corners.push_back(corner);
            }
        }
    }
    std::map<std::pair<int, int>, bool> full;
    for (const RefCorner& c : corners)
        full[std::make_pair((c.y - edge) / p.cellSize, (c.x - edge) / p.cellSize)] |= c.score >= iniT;
    RefCorners passed;
    for (const RefCorner& c : corners)
    {
        const bool inFull = full[std::make_pair((c.y - edge) / p.cellSize, (c.x - edge) / p.cellSize)];
        (c.score >= iniT || !inFull ? passed : level.rejects).push_back(c);
    }
    for (const RefCorner& c : passed)
    {
        bool falls = false;
        for (const RefCorner& o : passed)
        {
            falls = falls || (p.isHarris && std::abs(o.x - c.x) <= 3 && std::abs(o.y - c.y) <= 3 &&
                              std::make_tuple(-o.score, o.y, o.x) < std::make_tuple(-c.score, c.y, c.x));
        }
        (falls ? level.fallen : level.kept).push_back(c);
    }
    level.all = level.kept;
    level.all.insert(level.all.end(), level.fallen.begin(), level.fallen.end());
    level.all.insert(level.all.end(), level.rejects.begin(), level.rejects.end());
}

class RefSelection
{
public:
    RefSelection(std::vector<RefLevel>& levels_, Size imageSize_, const ReferenceParameters& p_)
        : levels(levels_), imageSize(imageSize_), p(p_)
    {
    }
    void select(int skippedQuota)
    {
        int wanted = skippedQuota;
        const int count = (int)levels.size();
        for (int l = count - 1; l >= 0; l--)
        {
            wanted += levels[l].quota;
            if (wanted > 0)
                wanted -= choose(l, wanted);
        }
        for (int l = 0; l < count && wanted > 0; l++)
            wanted -= choose(l, wanted);
        for (int l = 0; l < count && wanted > 0; l++)
            wanted -= fill(l, levels[l].passedOver, wanted);
        for (int l = 0; l < count && wanted > 0; l++)
            wanted -= fill(l, range(levels[l].kept.size(), levels[l].fallen.size()), wanted);
        for (int l = 0; l < count && wanted > 0; l++)
            wanted -= fill(
                l, range(levels[l].kept.size() + levels[l].fallen.size(), levels[l].rejects.size()), wanted);
    }

private:
    static std::vector<int> range(size_t first, size_t count)
    {
        std::vector<int> indices;
        for (size_t i = 0; i < count; i++)
            indices.push_back(int(first + i));
        return indices;
    }
    Point2d place(int l, int index) const
    {
        const RefCorner& c = levels[l].all[index];
        return Point2d((c.x + 0.5) * imageSize.width / levels[l].image.cols - 0.5,
                       (c.y + 0.5) * imageSize.height / levels[l].image.rows - 0.5);
    }
    bool isSuppressed(int l, int index) const
    {
        const double radius = p.octaveSuppression * levels[l].scale;
        for (size_t other = 0; other < levels.size(); other++)
        {
            for (size_t i = 0; i < levels[other].chosen.size(); i++)
            {
                const Point2d d = place((int)other, levels[other].chosen[i]) - place(l, index);
                if ((int)other != l && d.x * d.x + d.y * d.y < radius * radius)
                    return true;
            }
        }
        return false;
    }
    std::vector<int> sequenceOf(int l, const std::vector<int>& indices) const
    {
        const Size size = levels[l].image.size();
        const int64 edge = p.edgeThreshold, leaves = int64(1) << levels[l].depth;
        std::vector<LeafPoint> points;
        for (int index : indices)
        {
            const RefCorner& c = levels[l].all[index];
            const int64 column = std::min((c.x - edge) * leaves / (size.width - 2 * edge), leaves - 1);
            const int64 row = std::min((c.y - edge) * leaves / (size.height - 2 * edge), leaves - 1);
            unsigned code = 0;
            for (int bit = 0; bit < 15; bit++)
                code |= unsigned((column >> bit) & 1) << (2 * bit) | unsigned((row >> bit) & 1)
                                                                         << (2 * bit + 1);
            const LeafPoint point = {code, c.response, (float)c.x, (float)c.y, index};
            points.push_back(point);
        }
        return referenceSequence(points, levels[l].depth);
    }
    int choose(int l, int wanted)
    {
        RefLevel& level = levels[l];
        const bool first = !level.begun;
        if (first)
        {
            std::vector<int> candidates;
            for (int i : range(0, level.kept.size()))
                (isSuppressed(l, i) ? level.passedOver : candidates).push_back(i);
            level.sequence = sequenceOf(l, candidates);
            level.begun = true;
        }
        int taken = 0;
        for (; level.next < level.sequence.size() && taken < wanted; level.next++)
        {
            const int index = level.sequence[level.next];
            if (!first && isSuppressed(l, index))
            {
                level.passedOver.push_back(index);
                continue;
            }
            level.chosen.push_back(index);
            taken++;
        }
        return taken;
    }
    int fill(int l, const std::vector<int>& indices, int wanted)
    {
        const std::vector<int> sequence = sequenceOf(l, indices);
        const int count = std::min(wanted, (int)sequence.size());
        levels[l].chosen.insert(levels[l].chosen.end(), sequence.begin(), sequence.begin() + count);
        return count;
    }

    std::vector<RefLevel>& levels;
    Size imageSize;
    const ReferenceParameters& p;
};

void describe(const Mat& image, int x, int y, float angle, const ReferenceParameters& p, uchar* descriptor)
{
    const std::vector<Point> pattern = aqorb::stages::descriptorPattern(p.patchSize, p.WTA_K);
    angle *= (float)(CV_PI / 180.f);
    const float a = (float)cos(angle), b = (float)sin(angle);
    std::vector<int> values;
    for (const Point& point : pattern)
    {
        const Point q(x + cvRound(point.x * a - point.y * b), y + cvRound(point.x * b + point.y * a));
        const bool inside = Rect(Point(), image.size()).contains(q);
        values.push_back(inside ? saturate_cast<uchar>(referenceBlur(image, q))
                                : reflectedPixel(image, q.x, q.y));
    }
    const int bits = p.WTA_K == 2 ? 1 : 2;
    std::fill(descriptor, descriptor + 32, uchar(0));
    for (int test = 0; test < 256 / bits; test++)
    {
        const int* v = &values[test * p.WTA_K];
        int result;
        if (p.WTA_K == 2)
            result = v[0] < v[1];
        else if (p.WTA_K == 3)
            result = v[2] > v[1] ? (v[2] > v[0] ? 2 : 0) : v[1] > v[0];
        else
        {
            const int u = v[1] > v[0] ? 1 : 0, w = v[3] > v[2] ? 3 : 2;
            result = v[u] > v[w] ? u : w;
        }
        descriptor[test * bits / 8] |= uchar(result << (test * bits % 8));
    }
}

}  // namespace

Features referenceFeatures(const Mat& image, const Mat& mask, const ReferenceParameters& p)
{
    // equation (7)
    double sum = 0, squares = 0, count = 0;
    for (int y = 0; y < image.rows; y++)
    {
        for (int x = 0; x < image.cols; x++)
        {
            if (mask.empty() || mask.at<uchar>(y, x))
            {
                const double v = image.at<uchar>(y, x);
                sum += v;
                squares += v * v;
                count++;
            }
        }
    }
    const int fast = std::min(std::max(p.fastThreshold, 0), 255);
    double v = sum == 0 ? 0 : squares / sum - sum / count;
    v = p.adaptiveThreshold ? v * fast / 20 : fast;
    const int iniT = cvRound(std::min(std::max(v, 1.), 254.));
    const int loosest = std::min(std::max(fast, 1), iniT);
    const int minT = cvRound(std::min(std::max(v / p.minThresholdRatio, 1.), (double)loosest));

    // equation (8)
    std::vector<int> quotas(p.nlevels);
    const float factor = (float)(1.0 / p.scaleFactor);
    float desired = p.nfeatures * (1 - factor) / (1 - (float)std::pow((double)factor, (double)p.nlevels));
    int total = 0;
    for (int l = 0; l < p.nlevels - 1; l++)
    {
        quotas[l] = cvRound(desired);
        total += quotas[l];
        desired *= factor;
    }
    quotas[p.nlevels - 1] = std::max(p.nfeatures - total, 0);
    total += quotas[p.nlevels - 1];
    for (int l = 0; total > p.nfeatures; quotas[l] > 0 ? (quotas[l]--, total--) : l++)
    {
    }

    std::vector<RefLevel> levels;
    std::vector<Mat> masks;
    int skipped = 0;
    for (int l = 0; l < p.nlevels; l++)
    {
        RefLevel level = RefLevel();
        level.scale = (float)std::pow(p.scaleFactor, (double)(l - p.firstLevel));
        level.quota = quotas[l];
        const Size size(cvRound(image.cols * (1.f / level.scale)), cvRound(image.rows * (1.f / level.scale)));
        if (std::min(size.width, size.height) <= 2 * std::max(p.edgeThreshold, 3))
        {
            for (int rest = l; rest < p.nlevels; rest++)
                skipped += quotas[rest];
            break;
        }
        Mat levelMask = mask;
        if (l == p.firstLevel)
        {
            level.image = image;
        }
        else
        {
            const bool fromImage = l <= p.firstLevel + 1;
            resize(fromImage ? image : levels[l - 1].image, level.image, size, 0, 0, INTER_LINEAR_EXACT);
            if (!mask.empty())
                levelMask = reducedMask(fromImage ? mask : masks[l - 1], size);
        }
        masks.push_back(levelMask.clone());
        level.depth = p.maxDepth;
        if (p.maxDepth < 0)
        {
            for (level.depth = 0; level.depth < 15 && std::pow(4., level.depth) < level.quota;)
                level.depth++;
        }
        levels.push_back(level);
    }
    for (size_t l = 0; l < levels.size(); l++)
    {
        if (!mask.empty() && (int)l != p.firstLevel)
        {
            for (int y = 0; y < masks[l].rows; y++)
            {
                for (int x = 0; x < masks[l].cols; x++)
                {
                    const Point2f pt =
                        positionOf(image.size(), levels[l], p.edgeThreshold, p.subPixel, x, y, 0, 0);
                    const Point at(std::min(std::max(cvRound(pt.x), 0), image.cols - 1),
                                   std::min(std::max(cvRound(pt.y), 0), image.rows - 1));
                    if (!mask.at<uchar>(at))
                        masks[l].at<uchar>(y, x) = 0;
                }
            }
        }
        findCorners(levels[l].image, masks[l], iniT, minT, p, levels[l]);
    }
    RefSelection(levels, image.size(), p).select(skipped);

    Features features;
    for (size_t l = 0; l < levels.size(); l++)
    {
        const RefLevel& level = levels[l];
        RefCorners chosen;
        for (int index : level.chosen)
            chosen.push_back(level.all[index]);
        std::sort(chosen.begin(), chosen.end(),
                  [](const RefCorner& a, const RefCorner& b)
                  { return std::make_pair(a.y, a.x) < std::make_pair(b.y, b.x); });
        for (const RefCorner& c : chosen)
        {
            Point2f pt = positionOf(image.size(), level, p.edgeThreshold, p.subPixel, c.x, c.y, 0, 0);
            if (p.subPixel)
            {
                const Point2d d = peakOf(level.image, c.x, c.y);
                const Point2f refined =
                    positionOf(image.size(), level, p.edgeThreshold, true, c.x, c.y, d.x, d.y);
                if (mask.empty() || mask.at<uchar>(cvRound(refined.y), cvRound(refined.x)))
                    pt = refined;
            }
            const float angle = referenceAngle(level.image, c.x, c.y, p.patchSize);
            features.keypoints.push_back(
                KeyPoint(pt, p.patchSize * level.scale, angle, c.response, (int)l, -1));
            Mat descriptor(1, 32, CV_8UC1);
            describe(level.image, c.x, c.y, angle, p, descriptor.ptr());
            features.descriptors.push_back(descriptor);
        }
    }
    return features;
}

}  // namespace opencv_test
