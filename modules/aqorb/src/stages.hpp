// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_STAGES_HPP
#define OPENCV_AQORB_STAGES_HPP

#include <opencv2/core.hpp>

#include <vector>

// The stages of the algorithm in the order in which data passes through them, one stage a source
// file:
//
//   input -> thresholds -> pyramid -> FAST -> corners -> Harris -> quadtree -> selection
//         -> position -> orientation -> blur -> descriptor
//
// A stage takes plain input, returns plain output and keeps no state but in the objects it is given. They are
// exported for the accuracy tests only; this header is not installed and no part of the interface.

namespace cv
{
namespace aqorb
{
namespace stages
{

//! One level of the pyramid. Pixels outside of `image` are its reflection (BORDER_REFLECT_101).
struct Level
{
    Mat image;     //!< CV_8UC1
    Mat mask;      //!< CV_8UC1 of the same size, not 0 where a corner may lie; empty: everywhere
    float scale;   //!< size of a pixel of this level in pixels of the input image
    bool isInput;  //!< whether it is the input image itself
};

//! A FAST corner: a pixel of a level and its FAST score (the highest threshold at which it is one).
struct Corner
{
    int x, y;
    int score;
};

//! A corner with the score that ranks it.
struct RankedCorner
{
    int x, y;
    float response;
};

//! Order by rows, and by columns within a row. A type, as sorting does not inline calls of a function.
struct InRasterOrder
{
    template <typename C> bool operator()(const C& a, const C& b) const
    {
        return a.y != b.y ? a.y < b.y : a.x < b.x;
    }
};

// ---- input.cpp -------------------------------------------------------------------------------

//! The grey image: the input itself, or its conversion as cv::ORB does it. Throws for anything else.
CV_EXPORTS Mat grayImage(InputArray image);

//! Throws unless both sides are > 0.
CV_EXPORTS void checkImageSize(Size imageSize);

//! The mask, or an empty Mat; throws for another size or type.
CV_EXPORTS Mat checkedMask(InputArray mask, Size imageSize);

// ---- patch.cpp -------------------------------------------------------------------------------

//! Copies a rectangle, row by row without gaps; pixels outside of the image are reflected.
CV_EXPORTS void copyReflected(const Mat& image, const Rect& rect, uchar* out);

//! Pixels around a pixel of a level, readable within a radius.
struct Patch
{
    const uchar* center;
    ptrdiff_t step;
};

typedef AutoBuffer<uchar, 2048> PatchBuffer;

/** The square patch of the given radius around (x, y): in place where it lies inside the image, else
 a copy in the buffer, filled up by reflection. */
CV_EXPORTS Patch patchAround(const Mat& image, int x, int y, int radius, PatchBuffer& buffer);

// ---- threshold.dispatch.cpp ------------------------------------------------------------------

//! FAST thresholds of an image: `ini` everywhere, `min` in cells that have no corner at `ini`.
struct Thresholds
{
    int ini, min;
};

//! Equation (7) for a CV_8UC1 image: variance over mean of the unmasked pixels; 0 where the mean is 0.
CV_EXPORTS double varianceOverMean(const Mat& image, const Mat& mask);

//! iniT and minT from equation (7)'s value; `fastThreshold` 20 stands for the equation as it is.
CV_EXPORTS Thresholds adaptiveThresholds(double varianceOverMean, int fastThreshold, double minRatio);

//! iniT and minT without equation (7): iniT is fastThreshold itself.
CV_EXPORTS Thresholds fixedThresholds(int fastThreshold, double minRatio);

// ---- pyramid.dispatch.cpp --------------------------------------------------------------------

//! The size of a pixel of a level in pixels of the input image, as cv::ORB computes it.
CV_EXPORTS float levelScale(int level, int firstLevel, double scaleFactor);

//! The size of a level, as cv::ORB computes it; a side may be 0. Throws where it exceeds 2^20 - 1.
CV_EXPORTS Size levelSize(Size imageSize, float scale);

//! Number of features of each level, equation (8), rounded as by cv::ORB but at most nfeatures in all.
CV_EXPORTS std::vector<int> levelQuotas(int nfeatures, double scaleFactor, int nlevels);

//! cv::resize with INTER_LINEAR_EXACT for CV_8UC1, without its overhead for one channel.
CV_EXPORTS void resizeExact(const Mat& source, Mat& destination, Size size);

struct ResizeTables;
//! Work space of fillPyramid, for one call after the other: what depends on sizes only, by level.
typedef std::vector<Ptr<ResizeTables>> PyramidScratch;

/** The levels of cv::ORB's pyramid, level firstLevel being the image itself (not copied), the others
 without values as yet. Stops before the first level with a side below minSide. The memory of levels of
 the same size is used again. */
CV_EXPORTS void layOutPyramid(const Mat& image, const Mat& mask, int nlevels, int firstLevel,
                              double scaleFactor, int minSide, std::vector<Level>& levels);

//! The other levels. With a mask, each level's mask holds the pixels that are made of usable pixels only.
CV_EXPORTS void fillPyramid(const Mat& image, const Mat& mask, int firstLevel, std::vector<Level>& levels,
                            PyramidScratch& scratch);

//! Both.
CV_EXPORTS void buildPyramid(const Mat& image, const Mat& mask, int nlevels, int firstLevel,
                             double scaleFactor, int minSide, std::vector<Level>& levels);

// ---- fast.dispatch.cpp -----------------------------------------------------------------------

/** FAST-9/16 corners of score >= threshold with 3x3 non-maximum suppression whose centres lie in the
 region, in raster order, appended. The same as cv::FAST on the whole image, cut to the region. */
CV_EXPORTS void detectCorners(const Mat& image, const Rect& region, int threshold,
                              std::vector<Corner>& corners);

//! Corners among neighbouring pixels of a row.
struct CornerBlock
{
    int x, y;        //!< the first pixel
    uint64 columns;  //!< bit i: whether there is one at x + i
};

//! Blocks in raster order, at the beginning of room for more.
struct CornerBlocks
{
    CornerBlocks() : count(0), cornerCount(0) {}

    std::vector<CornerBlock> room;
    int count, cornerCount;
};

//! The scores of corners by pixel, 0 where there is none.
class CV_EXPORTS ScorePlane
{
public:
    //! Begins anew, for corners in a region of an image of the given width.
    void begin(int imageWidth, const Rect& region);
    //! By column of the image. SUPPRESS_RADIUS rows and SUPPRESS_MARGIN columns around the region are readable.
    uchar* row(int y) { return bytes.data() + first + (y - top) * step(); }
    const uchar* row(int y) const { return bytes.data() + first + (y - top) * step(); }
    ptrdiff_t step() const { return rowBytes; }

private:
    std::vector<uchar> bytes;
    ptrdiff_t first, rowBytes;
    int top;
};

//! The part of a region in which there may be FAST corners: pixels that have a whole circle.
CV_EXPORTS Rect fastRegion(Size imageSize, const Rect& region);

/** Finds the FAST corners of a region of a level from top to bottom, some rows at a time: those of score >=
 thresholds.min, of which those of score >= thresholds.ini are called strong and the others weak. */
class CV_EXPORTS FastScanner
{
public:
    FastScanner();
    /** Begins anew.
     @param region inside fastRegion, not empty
     @param plane gets the scores of the corners of all rows of the region, one more than Corner's
     @param found gets the corners */
    void begin(const Level& level, const Rect& region, Thresholds thresholds, ScorePlane& plane,
               CornerBlocks& found);
    //! Scans on, up to the row before `end`.
    void scan(int end);
    //! Whether the rows of the last scan have a strong corner in some columns.
    bool hasStrong(const Range& columns) const;
    //! Leaves the weak corners of the last scan out in some columns.
    void dropWeak(const Range& columns);
    //! Adds what is left of the last scan to the corners found.
    void settle();

private:
    class Impl;
    Ptr<Impl> impl;
};

//! The corners of blocks, in raster order, appended.
CV_EXPORTS void listCorners(const CornerBlocks& blocks, const ScorePlane& plane,
                            std::vector<Corner>& corners);

/** The unthresholded FAST score at p, -255 to 255: the largest over the 16 arcs of 9 circle pixels
 of their least difference to the centre, brighter or darker. One more than cv::FAST's response. */
CV_EXPORTS int cornerScore(const uchar* p, size_t step);

//! cornerScore at (x, y) and its neighbours, scores[1 + dy][1 + dx].
CV_EXPORTS void cornerScores3x3(const Mat& image, int x, int y, int scores[3][3]);

// ---- corners.dispatch.cpp --------------------------------------------------------------------

//! What corner detection on a level gives: the corners to choose from, and those that suppression passes over.
struct LevelCorners
{
    std::vector<Corner> kept;
    std::vector<Corner> suppressed;  //!< fell to a better corner within radius 3
};

//! Work space of findCorners, for one call after the other.
struct CornerScratch
{
    FastScanner scanner;
    ScorePlane plane;
    CornerBlocks blocks;
    std::vector<Corner> all;
};

//! Rows of a region whose corners are found by themselves, whole rows of cells; empty for an index too high.
CV_EXPORTS Range cornerBand(const Rect& region, int cellSize, int index);

/** The corners of a band that findCorners finds, before any is suppressed.
 @param plane begun for fastRegion of the whole region; other bands may be searched at once
 @param found only those of this band */
CV_EXPORTS void findBandCorners(const Level& level, const Rect& band, Thresholds thresholds, int cellSize,
                                ScorePlane& plane, CornerBlocks& found, FastScanner& scanner);

/** The corners of a band but those that fall to a better one nearby, even if that falls itself.
 @param plane of the whole region */
CV_EXPORTS void suppressCorners(const CornerBlocks& blocks, const ScorePlane& plane,
                                std::vector<Corner>& kept);

//! Corners that are not among others; all in raster order.
CV_EXPORTS void cornersWithout(const std::vector<Corner>& corners, const std::vector<Corner>& without,
                               std::vector<Corner>& rest);

/** Corners of a level inside `region`: score >= thresholds.ini; in cells of side cellSize (the first
 begins at the region's corner) that have none, score >= thresholds.min. Corners off the mask do not
 count. With suppressNear a corner falls to any other one with |dx|, |dy| <= 3 and a higher score (equal:
 lower y, then lower x), even to one that falls itself. */
CV_EXPORTS void findCorners(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                            bool suppressNear, LevelCorners& corners, CornerScratch& scratch);

/** The corners of score >= thresholds.min that the cell rule of findCorners passes over.
 @param found those that it does not, before any is suppressed */
CV_EXPORTS void findCellRejects(const Level& level, const Rect& region, Thresholds thresholds,
                                const std::vector<Corner>& found, std::vector<Corner>& corners);
CV_EXPORTS void findCellRejects(const Level& level, const Rect& region, Thresholds thresholds, int cellSize,
                                std::vector<Corner>& corners);

// ---- harris.dispatch.cpp ---------------------------------------------------------------------

//! cv::ORB's Harris response, over a 5x5 instead of a 7x7 block.
CV_EXPORTS float harrisResponse(const Mat& image, int x, int y);

//! The corners with their harrisResponse.
CV_EXPORTS void harrisResponses(const Mat& image, const std::vector<Corner>& corners,
                                std::vector<RankedCorner>& ranked);

// ---- quadtree.cpp ----------------------------------------------------------------------------

//! Deepest quadtree: 2^15 leaves along a side.
const int MAX_QUADTREE_DEPTH = 15;

//! Equation (9): the smallest depth D with 4^D >= quota, at most MAX_QUADTREE_DEPTH.
CV_EXPORTS int quadtreeDepth(int quota);

//! Morton code of the leaf of a quadtree of the given depth at (column, row).
CV_EXPORTS unsigned leafCode(unsigned column, unsigned row);

//! A point in a leaf of the quadtree.
struct LeafPoint
{
    unsigned leaf;   //!< Morton code
    float response;  //!< NaN ranks last
    float x, y;      //!< break ties: lower y first, then lower x, then lower index
    int index;       //!< the caller's
};

//! Work space of leafPoints.
struct LeafScratch
{
    std::vector<unsigned> columns, rows;
};

//! Assigns corners, all inside the root, to the leaves of a quadtree. Sides of a level are exact in float.
CV_EXPORTS void leafPoints(const std::vector<RankedCorner>& corners, const Rect& root, int depth,
                           LeafScratch& scratch, std::vector<LeafPoint>& points);

//! Tells which points are to be left out.
class PointFilter
{
public:
    virtual ~PointFilter() {}
    virtual bool accepts(const LeafPoint& point) const = 0;
};

/** Gives points in an order of which each prefix is the best selection of that many: balanced over the
 tree first, then by response. Leaves are grouped by their ancestor two levels up; a group offers the
 best of each of its leaves, then the second best of each, ..., each round by response; the sequence
 takes the first of every group by response, then the second of every group, ... */
class CV_EXPORTS BalancedSequence
{
public:
    BalancedSequence() : given(0) {}
    //! Begins anew. Takes the points and leaves other memory in exchange. Fastest for points in raster order.
    void begin(std::vector<LeafPoint>& points, int depth);
    //! The next point; false if there is none. As if those that the filter rejects had never been there;
    //! it is asked for few points but those given, and must not change its mind.
    bool next(LeafPoint& point, const PointFilter* filter = 0);

private:
    struct Leaf
    {
        Leaf(unsigned begin_, unsigned end_) : next(0), begin(begin_), end(end_), taken(0) {}
        uint64 next;                 // keys below it are taken
        unsigned begin, end, taken;  // in keys
    };
    struct Group
    {
        unsigned code;        // of the leaves' ancestor
        unsigned begin, end;  // in leaves: those that are not exhausted
    };
    void addLeaf(unsigned code, unsigned begin, unsigned end);
    uint64 takeBest(Leaf& leaf);
    uint64 takeNext(Group& group, const PointFilter* filter);

    std::vector<LeafPoint> points;  // in raster order
    std::vector<uint64> keys;       // of the points: the better one has the lower; by leaf
    std::vector<Leaf> leaves;
    std::vector<uint64> candidates;  // by leaf: what its group may take next
    std::vector<Group> groups;       // those that have more to offer
    std::vector<uint64> offers;      // of this round, the best first
    size_t given;                    // of the offers
};

// ---- selection.cpp ---------------------------------------------------------------------------

//! The corners of a level that selection may ask for.
enum CornerSet
{
    KEPT_CORNERS,        //!< findCorners: kept
    SUPPRESSED_CORNERS,  //!< findCorners: suppressed
    CELL_REJECTS         //!< findCellRejects
};

//! Gives selection the corners of a level; asked only for what is needed.
class CornerSource
{
public:
    virtual ~CornerSource() {}
    //! The sequence of the kept corners, as it was left the last time.
    virtual BalancedSequence& sequence(int level) = 0;
    virtual void corners(int level, CornerSet set, std::vector<RankedCorner>& corners) = 0;
};

//! What selection must know of a level.
struct SelectionLevel
{
    Size size;    //!< of the level
    float scale;  //!< of the level
    Rect root;    //!< of the quadtree: the region between the borders
    int depth;    //!< of the quadtree
    int quota;    //!< number of features the level is to have
};

/** Chooses the features of all levels, from coarse to fine: of each level's balanced sequence as many
 as its quota and what coarser levels left over, passing over corners nearer than octaveSuppression
 pixels of their level to a keypoint of a coarser one. What remains is offered to the levels from fine
 to coarse, then filled from the corners that the rules passed over.
 An object can be used again, and then needs no new memory. */
class CV_EXPORTS FeatureSelector
{
public:
    FeatureSelector();
    void select(const std::vector<SelectionLevel>& levels, Size imageSize, double octaveSuppression,
                CornerSource& source, std::vector<std::vector<RankedCorner>>& chosen);

private:
    class Impl;
    Ptr<Impl> impl;
};

// ---- position.cpp ----------------------------------------------------------------------------

//! Maps pixels of a level to positions in the input image.
struct PositionMap
{
    Size imageSize, levelSize;
    float scale;
    int border;     //!< positions stay this far inside the image where the pixel allows it
    bool subPixel;  //!< false: pixel times scale, as cv::ORB

    //! The position of the point (dx, dy), each within +-0.5, off the centre of pixel (x, y).
    CV_EXPORTS Point2f operator()(int x, int y, double dx = 0, double dy = 0) const;
};

//! Clears the pixels of a level's mask whose position rounds to a masked pixel of the input image.
CV_EXPORTS void maskPositions(const Mat& imageMask, const PositionMap& position, Mat& levelMask);

//! Where the quadratic through the 3x3 FAST scores around (x, y) peaks, relative to it, within +-0.5.
CV_EXPORTS Point2d subPixelOffset(const Mat& image, int x, int y);

// ---- orientation.dispatch.cpp ----------------------------------------------------------------

//! Where and in which direction a descriptor is to be taken.
struct DescriptorPoint
{
    int x, y;
    float angle;  //!< degrees
};

//! Half widths of the rows 0 .. patchSize/2 of the circular patch, as cv::ORB's.
CV_EXPORTS std::vector<int> circularPatch(int patchSize);

//! Direction of the intensity centroid of the patch around (x, y), degrees, as cv::ORB's.
CV_EXPORTS float orientation(const Mat& image, int x, int y, const std::vector<int>& halfWidths);

struct PatchWeights;
//! A circular patch, prepared for any number of points.
struct CV_EXPORTS OrientationPatch
{
    OrientationPatch() {}
    explicit OrientationPatch(const std::vector<int>& halfWidths);

    std::vector<int> halfWidths;
    Ptr<PatchWeights> weights;  //!< empty where the patch is too large for the kernel
};

//! Sets the angles of points to their orientation.
CV_EXPORTS void orientations(const Mat& image, const OrientationPatch& patch, DescriptorPoint* points,
                             size_t count);
inline void orientations(const Mat& image, const std::vector<int>& halfWidths, DescriptorPoint* points,
                         size_t count)
{
    orientations(image, OrientationPatch(halfWidths), points, count);
}

// ---- blur.dispatch.cpp -----------------------------------------------------------------------

/** The value of cv::ORB's Gaussian blur (7x7, sigma 2) at a pixel of a level, rounded as with fused
 multiply-add. */
CV_EXPORTS uchar exactBlur(const Mat& image, int x, int y);

//! Bound on the distance of approximateBlur from the exact one before rounding, in units of 1/256.
const int BLUR_BOUND = 6;

/** The pixels of a level that are to be blurred: by columns of tiles, the rows. The pixels at the border, whose
 blur needs reflected ones, have tiles of their own. */
class CV_EXPORTS BlurRegion
{
public:
    //! Begins anew, without any pixels.
    void begin(Size size);
    //! Adds at least the pixels of a rectangle, as far as they are inside the level.
    void add(const Rect& rect);
    //! The next tile, after a position that begins with 0; false if there is none.
    bool nextTile(size_t& position, Rect& tile) const;

private:
    enum
    {
        TILE_WIDTH = 32  // whole vectors
    };
    int columnOf(int x) const;

    Size size;
    int columns;                // of tiles
    std::vector<uchar> needed;  // by column, by row
};

//! Work space of approximateBlur.
typedef std::vector<uchar> BlurScratch;

/** The same blur in fixed point, in units of 1/256, off by at most BLUR_BOUND.
 @param blurred CV_16UC1 of the image's size; pixels outside of the region get any value */
CV_EXPORTS void approximateBlur(const Mat& image, const BlurRegion& region, Mat& blurred,
                                BlurScratch& scratch);

//! The same of the whole image.
CV_EXPORTS void approximateBlur(const Mat& image, Mat& blurred);

// ---- descriptor.dispatch.cpp -----------------------------------------------------------------

//! The points that rBRIEF compares, WTA_K to a test, in the order of the tests; as cv::ORB draws them.
CV_EXPORTS std::vector<Point> descriptorPattern(int patchSize, int WTA_K);

//! How far from the keypoint the descriptor may read.
CV_EXPORTS int descriptorReach(const std::vector<Point>& pattern);

struct PairTests;
//! A pattern, prepared for any number of descriptors.
struct CV_EXPORTS DescriptorTests
{
    DescriptorTests() : WTA_K(0), reach(0) {}
    DescriptorTests(const std::vector<Point>& pattern, int WTA_K);

    std::vector<Point> pattern;
    int WTA_K;
    int reach;             //!< descriptorReach
    Ptr<PairTests> pairs;  //!< empty where there is no kernel for the pattern
};

/** The 32-byte descriptors at pixels of a level, equal to cv::ORB's.
 @param image the level
 @param blurred approximateBlur of it, wherever it lies within tests.reach of a point
 @param points, count where
 @param tests how
 @param descriptors one a row of `step` bytes */
CV_EXPORTS void computeDescriptors(const Mat& image, const Mat& blurred, const DescriptorPoint* points,
                                   size_t count, const DescriptorTests& tests, uchar* descriptors,
                                   size_t step);
inline void computeDescriptors(const Mat& image, const Mat& blurred, const DescriptorPoint* points,
                               size_t count, const std::vector<Point>& pattern, int WTA_K, uchar* descriptors,
                               size_t step)
{
    computeDescriptors(image, blurred, points, count, DescriptorTests(pattern, WTA_K), descriptors, step);
}

}  // namespace stages
}  // namespace aqorb
}  // namespace cv

#endif
