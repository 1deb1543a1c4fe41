# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

import os
from typing import List, Optional, Sequence, Tuple, Union, overload

import cv2
import numpy
from numpy.typing import NDArray

_Image = Optional[NDArray[numpy.uint8]]
_Mask = Union[NDArray[numpy.uint8], NDArray[numpy.bool_], None]
_KeyPointArray = NDArray[numpy.void]
_KeyPoints = Union[Sequence[cv2.KeyPoint], _KeyPointArray]
_Descriptors = Optional[NDArray[numpy.uint8]]
_Size = Sequence[int]
_FileName = Union[str, bytes, os.PathLike[str], os.PathLike[bytes]]

__all__ = ['AdaptiveQuadtreeORB', 'AdaptiveQuadtreeORB_BALANCED_SELECTION', 'AdaptiveQuadtreeORB_RANKED_SELECTION',
           'AdaptiveQuadtreeORB_create', 'adaptiveFastThreshold', 'distributionOccupancy', 'distributionUniformity',
           'error', 'getNumThreads', 'keypoint_dtype', 'keypointsFromArray', 'keypointsToArray', 'retainUniform',
           'setNumThreads']

__version__: str
AdaptiveQuadtreeORB_RANKED_SELECTION: int
AdaptiveQuadtreeORB_BALANCED_SELECTION: int
keypoint_dtype: numpy.dtype[numpy.void]

class error(cv2.error, ValueError):
    """The value of an argument is not accepted. The message names the argument. It is a ValueError and, where there
    is cv2, a cv2.error."""

class AdaptiveQuadtreeORB:
    """An ORB detector and descriptor whose keypoints are spread uniformly over the image.

    It has the methods of cv2.ORB, with the same parameters. Outputs are returned, so that descriptors is to be None.
    Methods that process images release the GIL. Several threads may share a detector: a parameter that one thread
    sets applies to the calls that begin later."""

    @staticmethod
    def create(nfeatures: int = ..., scaleFactor: float = ..., nlevels: int = ..., edgeThreshold: int = ...,
               firstLevel: int = ..., WTA_K: int = ..., scoreType: int = ..., patchSize: int = ...,
               fastThreshold: int = ...) -> AdaptiveQuadtreeORB:
        """Creates a detector. The parameters are those of cv2.ORB_create, in the same order. The default of
        edgeThreshold is 16, and fastThreshold scales the adaptive threshold."""

    @overload
    def detect(self, image: _Image, mask: _Mask = ...) -> Tuple[cv2.KeyPoint, ...]:
        """Returns the keypoints of an image, as a tuple. With a mask, only those at its nonzero pixels."""
    @overload
    def detect(self, images: Sequence[_Image],
               masks: Optional[Sequence[_Mask]] = ...) -> List[Tuple[cv2.KeyPoint, ...]]:
        """Does the same for several images and returns a list. There is one mask for each image, or none."""
    @overload
    def compute(self, image: _Image, keypoints: _KeyPointArray,
                descriptors: None = ...) -> Tuple[_KeyPointArray, _Descriptors]:
        """Computes the descriptors of given keypoints. Returns the keypoints that have one, and an array with a row
        for each, or None if there are none."""
    @overload
    def compute(self, image: _Image, keypoints: Sequence[cv2.KeyPoint],
                descriptors: None = ...) -> Tuple[Tuple[cv2.KeyPoint, ...], _Descriptors]:
        """Computes the descriptors of given keypoints. Returns the keypoints that have one, and an array with a row
        for each, or None if there are none."""
    @overload
    def compute(self, images: Sequence[_Image], keypoints: Sequence[_KeyPointArray],
                descriptors: None = ...) -> Tuple[List[_KeyPointArray], List[_Descriptors]]:
        """Does the same for several images and returns a list of each."""
    @overload
    def compute(self, images: Sequence[_Image], keypoints: Sequence[Sequence[cv2.KeyPoint]],
                descriptors: None = ...) -> Tuple[List[Tuple[cv2.KeyPoint, ...]], List[_Descriptors]]:
        """Does the same for several images and returns a list of each."""
    def detectAndCompute(self, image: _Image, mask: _Mask = ..., descriptors: None = ...,
                         useProvidedKeypoints: bool = ...) -> Tuple[Tuple[cv2.KeyPoint, ...], _Descriptors]:
        """Returns the keypoints of an image, as a tuple, and their descriptors, as an array with a row for each, or
        None if there are none. With a mask, only keypoints at its nonzero pixels are found."""
    def detectAndComputeArrays(self, image: _Image,
                               mask: _Mask = ...) -> Tuple[_KeyPointArray, NDArray[numpy.uint8]]:
        """Does what detectAndCompute does, without making an object for each keypoint. Returns an array of
        keypoint_dtype and an array of descriptors of shape (n, 32), also where n is 0. The field 'pt' of the first
        is an array of shape (n, 2)."""
    def buildPyramid(self, image: _Image) -> Tuple[NDArray[numpy.uint8], ...]:
        """Returns the levels of the pyramid in which keypoints are found, as grey images."""
    def releaseMemory(self) -> None:
        """Frees the work space that the detector keeps between calls. The next call allocates it anew."""

    def setMaxFeatures(self, maxFeatures: int) -> None:
        """Sets the number of keypoints to find; default 500."""
    def getMaxFeatures(self) -> int:
        """Returns the number of keypoints to find."""
    def setScaleFactor(self, scaleFactor: float) -> None:
        """Sets the ratio of the sizes of two neighbouring levels of the pyramid; default 1.2."""
    def getScaleFactor(self) -> float:
        """Returns the ratio of the sizes of two neighbouring levels of the pyramid."""
    def setNLevels(self, nlevels: int) -> None:
        """Sets the number of levels of the pyramid; default 8."""
    def getNLevels(self) -> int:
        """Returns the number of levels of the pyramid."""
    def setEdgeThreshold(self, edgeThreshold: int) -> None:
        """Sets the width, in pixels of each level, of the border without keypoints; default 16."""
    def getEdgeThreshold(self) -> int:
        """Returns the width, in pixels of each level, of the border without keypoints."""
    def setFirstLevel(self, firstLevel: int) -> None:
        """Sets the level of the pyramid that is the image itself; default 0. Lower levels are larger."""
    def getFirstLevel(self) -> int:
        """Returns the level of the pyramid that is the image itself."""
    def setWTA_K(self, wta_k: int) -> None:
        """Sets how many points each element of a descriptor compares: 2, 3 or 4; default 2."""
    def getWTA_K(self) -> int:
        """Returns how many points each element of a descriptor compares."""
    def setScoreType(self, scoreType: int) -> None:
        """Sets what a response is: cv2.ORB_HARRIS_SCORE, the default, or cv2.ORB_FAST_SCORE."""
    def getScoreType(self) -> int:
        """Returns what a response is: cv2.ORB_HARRIS_SCORE or cv2.ORB_FAST_SCORE."""
    def setPatchSize(self, patchSize: int) -> None:
        """Sets the side, in pixels of a level, of the patch that a descriptor describes; default 31."""
    def getPatchSize(self) -> int:
        """Returns the side, in pixels of a level, of the patch that a descriptor describes."""
    def setFastThreshold(self, fastThreshold: int) -> None:
        """Sets the scale of the adaptive FAST threshold, or the threshold itself where it is not adaptive. The
        default, 20, takes equation (7) as it is."""
    def getFastThreshold(self) -> int:
        """Returns the scale of the adaptive FAST threshold, or the threshold itself."""
    def setAdaptiveThreshold(self, adaptiveThreshold: bool) -> None:
        """Sets whether the FAST threshold adapts to the image; default True."""
    def getAdaptiveThreshold(self) -> bool:
        """Returns whether the FAST threshold adapts to the image."""
    def setMinThresholdRatio(self, minThresholdRatio: float) -> None:
        """Sets how many times lower the FAST threshold is in cells that would stay empty; >= 1, default 4."""
    def getMinThresholdRatio(self) -> float:
        """Returns how many times lower the FAST threshold is in cells that would stay empty."""
    def setCellSize(self, cellSize: int) -> None:
        """Sets the side, in pixels of a level, of the cells in which the lower threshold may apply; >= 8, default
        35."""
    def getCellSize(self) -> int:
        """Returns the side, in pixels of a level, of the cells in which the lower threshold may apply."""
    def setMaxDepth(self, maxDepth: int) -> None:
        """Sets the depth of the quadtree, 0 to 15. The default, -1, is as deep as the number of features asks for.
        With 0 corners are chosen by their response alone."""
    def getMaxDepth(self) -> int:
        """Returns the depth of the quadtree, or -1."""
    def setSelectionType(self, selectionType: int) -> None:
        """Sets the rule by which the corners of a level are chosen: AdaptiveQuadtreeORB_RANKED_SELECTION, the
        default, or AdaptiveQuadtreeORB_BALANCED_SELECTION, the paper's, which gives the keypoints of version 0.1."""
    def getSelectionType(self) -> int:
        """Returns the rule by which the corners of a level are chosen."""
    def setStrengthWeight(self, strengthWeight: float) -> None:
        """Sets how much the strength of a corner counts against an even distribution, 0 (most even) to 1000 (by
        strength alone); default 0.15. It has an effect with the ranked selection only."""
    def getStrengthWeight(self) -> float:
        """Returns how much the strength of a corner counts against an even distribution."""
    def setRankRadius(self, rankRadius: float) -> None:
        """Sets how far around a corner stronger ones are counted, 0 to 16, in units of the mean distance between the
        features of a level; default 1. It has an effect with the ranked selection only."""
    def getRankRadius(self) -> float:
        """Returns how far around a corner stronger ones are counted."""
    def setOctaveSuppression(self, octaveSuppression: float) -> None:
        """Sets how far a keypoint keeps those of other levels away, in pixels of the finer level. The default, -1,
        is 1.15 / (1 + StrengthWeight) with the ranked selection, which is 1 by default, and 0.5 with the balanced
        one."""
    def getOctaveSuppression(self) -> float:
        """Returns how far a keypoint keeps those of other levels away, or -1."""
    def setSubPixel(self, subPixel: bool) -> None:
        """Sets whether positions are refined to a fraction of a pixel; default True."""
    def getSubPixel(self) -> bool:
        """Returns whether positions are refined to a fraction of a pixel."""

    def getDefaultName(self) -> str:
        """Returns the name under which parameters are saved."""
    def descriptorSize(self) -> int:
        """Returns the number of bytes of a descriptor, 32."""
    def descriptorType(self) -> int:
        """Returns the type of a descriptor's elements, cv2.CV_8U."""
    def defaultNorm(self) -> int:
        """Returns the norm to match with: cv2.NORM_HAMMING, or cv2.NORM_HAMMING2 where WTA_K is 3 or 4."""
    def empty(self) -> bool:
        """Returns False, as there are parameters to write."""
    def clear(self) -> None:
        """Does nothing, as that of cv2.ORB."""
    @overload
    def write(self, fileName: _FileName) -> None:
        """Writes the parameters to an XML, YAML or JSON file."""
    @overload
    def write(self, fs: cv2.FileStorage, name: str = ...) -> None:
        """Writes the parameters to a cv2.FileStorage, under the name if one is given."""
    def save(self, fileName: _FileName) -> None:
        """Does the same as write(fileName)."""
    @overload
    def read(self, fileName: _FileName) -> None:
        """Reads the parameters that a file has. The others keep their values."""
    @overload
    def read(self, fn: cv2.FileNode) -> None:
        """Reads the parameters that the map of a cv2.FileNode has. The others keep their values."""

def AdaptiveQuadtreeORB_create(nfeatures: int = ..., scaleFactor: float = ..., nlevels: int = ...,
                               edgeThreshold: int = ..., firstLevel: int = ..., WTA_K: int = ...,
                               scoreType: int = ..., patchSize: int = ...,
                               fastThreshold: int = ...) -> AdaptiveQuadtreeORB:
    """Creates a detector. The parameters are those of cv2.ORB_create, in the same order. The default of
    edgeThreshold is 16, and fastThreshold scales the adaptive threshold."""
def adaptiveFastThreshold(image: _Image, mask: _Mask = ...) -> float:
    """Returns the adaptive FAST threshold of an image, equation (7): the variance of its grey values divided by
    their mean."""
def distributionUniformity(keypoints: _KeyPoints, imageSize: _Size) -> float:
    """Returns how uniformly the keypoints of any detector are distributed over an image of (width, height). A lower
    value is more uniform. Compare equal numbers of keypoints only."""
def distributionOccupancy(keypoints: _KeyPoints, imageSize: _Size, grid: _Size = ...) -> float:
    """Returns the share of the cells of a grid of (columns, rows) that hold at least one keypoint."""
@overload
def retainUniform(keypoints: _KeyPointArray, imageSize: _Size, npoints: int) -> _KeyPointArray:
    """Returns the npoints keypoints, of any detector, that are spread best over the image. It prefers high
    responses, and keeps the order of the keypoints."""
@overload
def retainUniform(keypoints: Sequence[cv2.KeyPoint], imageSize: _Size,
                  npoints: int) -> Tuple[cv2.KeyPoint, ...]:
    """Returns the npoints keypoints, of any detector, that are spread best over the image. It prefers high
    responses, and keeps the order of the keypoints."""
def keypointsToArray(keypoints: _KeyPoints) -> _KeyPointArray:
    """Returns an array of keypoint_dtype with the values of cv2.KeyPoint objects."""
def keypointsFromArray(keypoints: _KeyPointArray) -> Tuple[cv2.KeyPoint, ...]:
    """Returns a tuple of cv2.KeyPoint objects with the values of an array of keypoint_dtype."""
def setNumThreads(nthreads: int) -> None:
    """Sets the number of threads that a call may use, as cv2.setNumThreads does for cv2. A negative number is the
    default: the number of processors, or of the variable OPENCV_FOR_THREADS_NUM."""
def getNumThreads() -> int:
    """Returns the number of threads that a call may use."""
