"""The sensing process: frame sets in; frames, estimates and what viewers draw out."""

from collections.abc import Callable, Mapping
import logging
from threading import Event
import time

import cv2
import numpy as np

from drivers.cameras import CameraSettings, FrameSet, FrameSetPairing, open_cameras
from messaging import topics
from messaging.control import Reply, TendonState
from messaging.errors import NodalError
from messaging.frames import CameraCalibration, Frame
from messaging.message import Message
from messaging.session import Publisher, Session
from messaging.settings import RobotSettings
from messaging.shape import Flag, NodalPoints, ShapeEstimate
from messaging.views import CameraPoseView, CameraView, CentrelineView, NodalPointsView
from sensing.errors import SensingError
from sensing.picture import decoded
from sensing.pipeline import Scene, Shape, covered_nodes, estimate
from sensing.reporting import estimate_message, refusal_message
from sensing.settings import SensingSettings
from sensing.stage_height import StageHeight

logger = logging.getLogger(__name__)

POLL_S = 0.001
RIG_PERIOD_S = 1.0
