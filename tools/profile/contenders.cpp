// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

#include "contenders.hpp"

#include "measure.hpp"

#include <dlfcn.h>

using namespace cv;
using aqorb::AdaptiveQuadtreeORB;

namespace
{

// AdaptiveQuadtreeORB::create, as it is in every version up to now.
typedef Ptr<AdaptiveQuadtreeORB> (*CreateFunction)(int nfeatures, float scaleFactor, int nlevels,
                                                   int edgeThreshold, int firstLevel, int WTA_K,
                                                   ORB::ScoreType scoreType, int patchSize,
                                                   int fastThreshold);
const char* const CREATE_SYMBOL = "_ZN2cv5aqorb19AdaptiveQuadtreeORB6createEifiiiiNS_3ORB9ScoreTypeEii";

CreateFunction loadCreate(const std::string& library)
{
    int flags = RTLD_NOW | RTLD_LOCAL;
#ifdef RTLD_DEEPBIND
    flags |= RTLD_DEEPBIND;  // or the functions of this build would stand in for its own
#endif
    // A plain file name would be looked for in the system's folders.
    void* const handle =
        dlopen((library.find('/') == std::string::npos ? "./" + library : library).c_str(), flags);
    void* const symbol = handle ? dlsym(handle, CREATE_SYMBOL) : NULL;
    if (!symbol)
        CV_Error(Error::StsBadArg, library + " is not a shared library of aqorb: " + dlerror());
    const CreateFunction create = reinterpret_cast<CreateFunction>(symbol);
    if (create == static_cast<CreateFunction>(&AdaptiveQuadtreeORB::create))
        CV_Error(Error::StsBadArg, library + " is the library that is measured already");
    return create;
}

}  // namespace

std::vector<Contender> makeContenders(const std::string& beside)
{
    std::vector<Contender> contenders;
    for (Detector id : {CV_ORB, AQORB})
        contenders.push_back({nameOf(id), [id](int nfeatures) { return createDetector(id, nfeatures); }});
    if (!beside.empty())
    {
        const CreateFunction create = loadCreate(beside);
        const auto createAlike = [create](int nfeatures) -> Ptr<Feature2D>
        {
            // No symbol has the default values, so those of this build are taken.
            const Ptr<AdaptiveQuadtreeORB> here = AdaptiveQuadtreeORB::create(nfeatures);
            return create(nfeatures, float(here->getScaleFactor()), here->getNLevels(),
                          here->getEdgeThreshold(), here->getFirstLevel(), here->getWTA_K(),
                          here->getScoreType(), here->getPatchSize(), here->getFastThreshold());
        };
        contenders.push_back({"BESIDE " + beside.substr(beside.rfind('/') + 1), createAlike});
    }
    return contenders;
}
