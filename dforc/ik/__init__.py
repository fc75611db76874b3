from dforc.ik_old import IkResult, IkSettings, IkStatus, InverseKinematics

__all__ = ["IkResult", "IkSettings", "IkStatus", "InverseKinematics"]
