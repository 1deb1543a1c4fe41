// This file is part of the aqorb project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.

#ifndef OPENCV_AQORB_PYRAMID_CORNERS_HPP
#define OPENCV_AQORB_PYRAMID_CORNERS_HPP

#include "parameters.hpp"
#include "workspace.hpp"

namespace cv
{
namespace aqorb
{

// Detects and ranks the corners of the pyramid's levels for selection: in bands, of which several are searched
// at once, then level by level.
class PyramidCorners : public stages::CornerSource
{
public:
    PyramidCorners(const Parameters& parameters_, stages::Thresholds thresholds_, Workspace& workspace_,
                   Pool<TaskScratch>& scratches_)
        : parameters(parameters_),
          thresholds(thresholds_),
          workspace(workspace_),
          scratches(scratches_),
          bands(0)
    {
        workspace.ready.assign(workspace.pyramid.size(), uchar(0));
    }
    // Lays out the bands of the input image, or those of the other levels; returns the number of all bands so far.
    size_t layOutBands(bool ofInput)
    {
        for (int level = 0; level < int(workspace.pyramid.size()); level++)
        {
            if (workspace.pyramid[level].isInput == ofInput && workspace.selectionLevels[level].quota > 0)
                addBands(level);
        }
        return bands;
    }
    // Finds the corners of a band; several bands may be searched at once.
    void search(size_t index)
    {
        CV_TRACE_FUNCTION();
        CornerBand& band = workspace.bands[index];
        const Pool<TaskScratch>::Lease lent(scratches);
        stages::findBandCorners(workspace.pyramid[band.level], band.rect, thresholds, parameters.cellSize,
                                workspace.planes[band.level], band.blocks, (*lent).scanner);
    }
    // Suppresses and ranks the corners of a band, with all bands of its level searched; several bands may be ranked
    // at once.
    void rank(size_t index)
    {
        CV_TRACE_FUNCTION();
        CornerBand& band = workspace.bands[index];
        const stages::ScorePlane& plane = workspace.planes[band.level];
        // Harris responses of neighbours hardly differ: unsuppressed, a strong corner is taken thrice.
        if (isHarris())
        {
            stages::suppressCorners(band.blocks, plane, band.corners);
        }
        else
        {
            band.corners.clear();
            stages::listCorners(band.blocks, plane, band.corners);
        }
        score(band.level, band.corners, band.ranked);
        band.isRanked = true;
    }
    // Makes the corners of a level, whose bands are searched, ready to be asked for; several levels may be prepared at
    // once.
    void prepare(int level)
    {
        CV_TRACE_FUNCTION();
        const Pool<TaskScratch>::Lease lent(scratches);
        TaskScratch& scratch = *lent;
        scratch.ranked.clear();
        for (size_t i = 0; i < bands; i++)
        {
            CornerBand& band = workspace.bands[i];
            if (band.level != level)
                continue;
            if (!band.isRanked)
                rank(i);
            scratch.ranked.insert(scratch.ranked.end(), band.ranked.begin(), band.ranked.end());
        }
        const stages::SelectionLevel& root = workspace.selectionLevels[level];
        stages::leafPoints(scratch.ranked, root.root, root.depth, scratch.leaves, scratch.points);
        workspace.sequences[level].begin(scratch.points, root.depth);
        workspace.ready[level] = 1;
    }
    stages::BalancedSequence& sequence(int level) CV_OVERRIDE
    {
        if (!workspace.ready[level])  // as its quota is 0
        {
            const size_t first = bands;
            addBands(level);
            for (size_t i = first; i < bands; i++)
                search(i);
            prepare(level);
        }
        return workspace.sequences[level];
    }
    void corners(int level, stages::CornerSet set, std::vector<stages::RankedCorner>& ranked) CV_OVERRIDE
    {
        ranked.clear();
        std::vector<stages::Corner> found, kept, passedOver;
        for (size_t i = 0; i < bands; i++)
        {
            const CornerBand& band = workspace.bands[i];
            if (band.level != level)
                continue;
            ranked.insert(ranked.end(), band.ranked.begin(), band.ranked.end());
            kept.insert(kept.end(), band.corners.begin(), band.corners.end());
            stages::listCorners(band.blocks, workspace.planes[level], found);
        }
        if (set == stages::KEPT_CORNERS)
            return;
        if (set == stages::SUPPRESSED_CORNERS)
            stages::cornersWithout(found, kept, passedOver);
        else
            stages::findCellRejects(workspace.pyramid[level], workspace.selectionLevels[level].root,
                                    thresholds, found, passedOver);
        score(level, passedOver, ranked);
    }

private:
    void addBands(int level)
    {
        const Rect& root = workspace.selectionLevels[level].root;
        const Size size = workspace.pyramid[level].image.size();
        const Rect scanned = stages::fastRegion(size, root);
        if (scanned.empty())
            return;
        workspace.planes[level].begin(size.width, scanned);
        for (int i = 0;; i++, bands++)
        {
            const Range rows = stages::cornerBand(root, parameters.cellSize, i);
            if (rows.start >= rows.end)
                break;
            if (bands == workspace.bands.size())
                workspace.bands.push_back(CornerBand());
            CornerBand& band = workspace.bands[bands];
            band.level = level;
            band.rect = Rect(root.x, rows.start, root.width, rows.end - rows.start);
            band.isRanked = false;
        }
    }
    bool isHarris() const { return parameters.scoreType == ORB::HARRIS_SCORE; }

    void score(int level, const std::vector<stages::Corner>& unranked,
               std::vector<stages::RankedCorner>& ranked) const
    {
        if (isHarris())
        {
            stages::harrisResponses(workspace.pyramid[level].image, unranked, ranked);
            return;
        }
        ranked.resize(unranked.size());
        for (size_t i = 0; i < unranked.size(); i++)
        {
            const stages::RankedCorner corner = {unranked[i].x, unranked[i].y, float(unranked[i].score)};
            ranked[i] = corner;
        }
    }

    const Parameters& parameters;
    const stages::Thresholds thresholds;
    Workspace& workspace;
    Pool<TaskScratch>& scratches;
    size_t bands;  // of the workspace's
};

}  // namespace aqorb
}  // namespace cv

#endif
