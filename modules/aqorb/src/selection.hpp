// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// The rule by which corners become keypoints, declared in the order of doc/selection.md.

#ifndef OPENCV_AQORB_SELECTION_HPP
#define OPENCV_AQORB_SELECTION_HPP

#include "corners.hpp"
#include "index_sort.hpp"
#include "harris_orientation.hpp"
#include "parameters.hpp"
#include "types.hpp"

namespace cv
{
namespace aqorb
{

// ---- 1. quotas --------------------------------------------------------------------------------

//! The number of features of each level, nfeatures in all: in proportion to area * scale^1.25, and half as much again
//! for the finest level.
std::vector<int> rankedQuotas(int nfeatures, const std::vector<Size>& regions,
                              const std::vector<float>& scales);

//! The leaves of a quadtree: columns and rows of equal parts of a region.
struct LeafGrid
{
    int columns, rows;
    int columnBits;  //!< of a number

    unsigned numberOf(int column, int row) const { return unsigned(column) | unsigned(row) << columnBits; }
    int columnOf(unsigned leaf) const { return int(leaf & ((1u << columnBits) - 1)); }
    int rowOf(unsigned leaf) const { return int(leaf >> columnBits); }
    //! More than all numbers of leaves.
    size_t numbers() const { return size_t(rows) << columnBits; }
};

// ---- 2. tree ----------------------------------------------------------------------------------

//! The leaves of several trees side by side along the longer side of the region. Each has 2^depth columns and rows.
LeafGrid leafGrid(Size region, int trees, int depth);

//! The tree of the smallest depth with 9 usable leaves for each of `quota` points. Where its leaves would be shorter
//! than 2 pixels, there are longer side / shorter side (rounded down) trees. There are at most 2^24 leaves.
//! @param usable the share of the region that no mask excludes
LeafGrid rankedGrid(Size region, double usable, int quota);

//! The leaf of a position in a region.
inline unsigned leafOf(double x, double y, Size region, const LeafGrid& grid)
{
    return grid.numberOf(int(x * grid.columns / region.width), int(y * grid.rows / region.height));
}

// ---- 3. representatives -----------------------------------------------------------------------

//! A point that is to be put in order. Points come in the order that breaks ties.
struct LeafPoint
{
    unsigned leaf;  //!< see leafOf
    int key;        //!< the greater, the better: a FAST score, or the sortKey of a response
};

/** The best point of each leaf, unless at least three of the leaf's eight neighbours have a better one. Ties in a leaf
 go to the first point, and between leaves to the first leaf.
 @return their indices, in the order of the leaves */
std::vector<unsigned> findRepresentatives(const std::vector<LeafPoint>& points, const LeafGrid& grid);

// ---- 4. strength ------------------------------------------------------------------------------

//! Corners of a level with their responses: Harris responses or FAST scores.
std::vector<CornerResponse> responsesOf(const Mat& image, const std::vector<Corner>& corners, bool useHarris);
//! The patch of the moments: every third row of the default patch.
OrientationPatch patchForStrength(int patchSize);
//! The fourth powers of FAST * sqrt(sqrt(Harris)) * moment, so that no root is needed.
std::vector<float> strengthsOf(const Mat& image, const std::vector<Corner>& corners,
                               const std::vector<CornerResponse>& responses, bool useHarris,
                               const OrientationPatch& patch);

// ---- 5. rank, 6. order ------------------------------------------------------------------------

//! The region over which points are spread, and how.
struct RankRule
{
    Size region;      //!< in pixels
    LeafGrid grid;    //!< the leaves of the quadtree
    double usable;    //!< the share of the region in which points may lie
    int quota;        //!< the number of points that the region is to have, > 0
    double radius;    //!< of the disc in which stronger points count, in units of sqrt(usable area / quota)
    double exponent;  //!< of the strengths
};

/** The order of representatives: by (1 + rank) / strength^exponent. The rank is the number of stronger ones within a
 disc of leaves. Where a part of the square around the disc lies outside of the region, or is masked, the rank is scaled
 up.
 @param leaves, strengths of the representatives; equally strong ones come by their leaves
 @param usable by leaf: whether points may lie there; empty: everywhere
 @return indices of the list of representatives */
std::vector<unsigned> orderRepresentatives(const std::vector<unsigned>& leaves,
                                           const std::vector<float>& strengths, const RankRule& rule,
                                           const std::vector<uchar>& usable);

// ---- the method -------------------------------------------------------------------------------

//! The share of a level in the selection.
struct LevelPlan
{
    Rect region;  //!< in which keypoints may be
    int quota;    //!< number of features
};

//! What SelectionType decides.
struct SelectionMethod
{
    bool suppressNear;  //!< of CornerRules
    bool subPixel;      //!< whether positions are refined
    double
        octaveDistance;  //!< that a corner keeps from keypoints of neighbouring levels, in pixels of its own level
    //! The quotas of the levels, from their regions and scales. There may be more quotas than levels.
    std::vector<int> (*quotas)(const Parameters& parameters, const std::vector<Size>& regions,
                               const std::vector<float>& scales);
    //! The corners of a level that may become keypoints, in the order in which they are to be taken.
    std::vector<CornerResponse> (*order)(const Parameters& parameters,
                                         const OrientationPatch& patchForStrength, const LevelPlan& plan,
                                         const Level& level, const std::vector<Corner>& corners);
};
SelectionMethod selectionMethod(const Parameters& parameters);

// ---- 7. across levels, 8. when representatives run out, 9. order of output -----------------------

/** Finds corners and selects the keypoints among them. From coarse to fine, each level gives its quota and the features
 that coarser levels lack; then, from fine to coarse, levels give the features that are still missing. It passes over
 corners near a keypoint of another level. When corners run out, it searches again with fewer rules.
 @param patch for strengths
 @return for each level its features in raster order, with output keys */
std::vector<FeatureList> selectFeatures(const Parameters& parameters, const SelectionMethod& method,
                                        const OrientationPatch& patch, Size imageSize,
                                        const std::vector<Level>& levels, const Thresholds& thresholds,
                                        int threads, CornerSpace& space);
//! Puts the features of all levels in the order of the output: by level, then by output key, then in raster order.
//! @param descriptors a row for each feature; empty: they are not wanted
void outputFeatures(const std::vector<FeatureList>& features, std::vector<KeyPoint>& keypoints,
                    Mat& descriptors);

// ---- for the kernel: plain structs only, see types.hpp ---------------------------------------

//! A grid with a border and a bit for each leaf. A bit is set when the leaf has been counted. The words of a row begin
//! STEP bits apart and hold twice as many bits, so that the STEP bits from any leaf on lie in one word.
struct RankGrid
{
    enum
    {
        STEP = 32
    };
    uint64* bits;
    int columnBits;       //!< of the numbers of leaves, see LeafGrid
    int stride;           //!< words of a row
    int left, top;        //!< width of the border, in bits and rows
    const int* words;     //!< the disc: offsets from the word before its upper left one
    const uint64* masks;  //!< the disc: which bits of each of these words count
    int wordCount;
};

}  // namespace aqorb
}  // namespace cv

#endif
