// SPDX-License-Identifier: MIT
#include "crease/stepper/scene_io.hpp"

namespace crease {
namespace {

// The one description of the scene format: the reader checks every scene against this text and takes its defaults from
// here, so the published schema cannot differ from what is accepted. Key order here is the order of a resolved scene.
// "x-available" lists the values that this version can run, where the format knows more.
constexpr char schema_text[] = R"json({
  "$schema": "http://json-schema.org/draft-07/schema#",
  "title": "crease scene",
  "description": "All quantities in SI units (m, kg, s, N, J). File names are relative to the scene file.",
  "type": "object",
  "additionalProperties": false,
  "required": ["format", "name", "duration", "cloths"],
  "properties": {
    "$schema": {"type": "string", "description": "where an editor finds this schema; not used"},
    "format": {"enum": [1], "description": "version of the format"},
    "name": {"type": "string", "maxLength": 200, "pattern": "^[A-Za-z0-9_-]+$"},
    "description": {"type": "string", "default": ""},
    "duration": {"type": "number", "minimum": 0, "description": "simulated time [s]"},
    "time_step": {"type": "number", "exclusiveMinimum": 0, "default": 0.005, "description": "[s]"},
    "gravity": {"$ref": "#/definitions/vec3", "default": [0, 0, -9.81], "description": "[m/s^2]"},
    "cloths": {"type": "array", "minItems": 1, "items": {"$ref": "#/definitions/cloth"}},
    "obstacles": {"type": "array", "default": [], "items": {"$ref": "#/definitions/obstacle"}},
    "contact": {
      "type": "object",
      "default": {},
      "additionalProperties": false,
      "properties": {
        "method": {"enum": ["eol", "lagrangian_averaged", "lagrangian_cone"], "default": "eol"},
        "threshold": {"type": "number", "exclusiveMinimum": 0, "default": 0.001,
                      "description": "distance at which a contact begins [m]"},
        "friction": {"type": "number", "minimum": 0, "default": 0, "x-available": [0],
                     "description": "Coulomb coefficient"},
        "self": {"type": "boolean", "default": false, "x-available": [false],
                 "description": "cloth against itself and other cloths"}
      }
    },
    "dynamics": {
      "type": "object",
      "default": {},
      "additionalProperties": false,
      "properties": {
        "velocity_terms": {"type": "boolean", "default": true,
                           "description": "false: the published equations, without the terms quadratic in velocity"},
        "integrator": {"enum": ["linear", "newton"], "default": "linear", "x-available": ["linear"]}
      }
    },
    "solver": {
      "type": "object",
      "default": {},
      "additionalProperties": false,
      "properties": {
        "qp": {"enum": ["active_set", "ipopt"], "default": "active_set"},
        "tolerance": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1, "default": 1e-8,
                      "description": "relative residual of the optimality conditions"}
      }
    },
    "output": {
      "type": "object",
      "default": {},
      "additionalProperties": false,
      "properties": {
        "fps": {"type": "number", "exclusiveMinimum": 0, "default": 60, "description": "frames a second"},
        "formats": {"type": "array", "minItems": 1, "uniqueItems": true, "items": {"enum": ["vtp", "obj"]},
                    "default": ["vtp"]}
      }
    }
  },
  "definitions": {
    "vec2": {"type": "array", "items": {"type": "number", "minimum": -1000000000, "maximum": 1000000000}, "minItems": 2, "maxItems": 2},
    "vec3": {"type": "array", "items": {"type": "number", "minimum": -1000000000, "maximum": 1000000000}, "minItems": 3, "maxItems": 3},
    "label": {"type": "string", "maxLength": 200, "pattern": "^[!-~]([ -~]*[!-~])?$",
              "description": "printable ASCII; unique among its kind"},
    "cloth": {
      "type": "object",
      "additionalProperties": false,
      "required": ["shape", "material"],
      "properties": {
        "name": {"$ref": "#/definitions/label"},
        "shape": {
          "type": "object",
          "additionalProperties": false,
          "oneOf": [{"required": ["grid"]}, {"required": ["mesh"]}],
          "properties": {
            "grid": {
              "type": "object",
              "additionalProperties": false,
              "properties": {
                "size": {"type": "array", "items": {"type": "number", "exclusiveMinimum": 0}, "minItems": 2,
                         "maxItems": 2, "default": [1, 1], "description": "[m]"},
                "cells": {"type": "array", "items": {"type": "integer", "minimum": 1, "maximum": 4000}, "minItems": 2,
                          "maxItems": 2, "default": [10, 10]},
                "pattern": {"enum": ["cross", "alternating", "right", "irregular"], "default": "cross"},
                "seed": {"type": "integer", "minimum": 0, "maximum": 9007199254740991, "default": 1,
                         "description": "of the irregular pattern"}
              }
            },
            "mesh": {"type": "string",
                     "description": "OBJ file: v = world position, vt = material coordinate in metres"}
          }
        },
        "placement": {
          "type": "object",
          "description": "world = origin + U u + V v; of a grid only",
          "additionalProperties": false,
          "properties": {
            "origin": {"$ref": "#/definitions/vec3", "default": [0, 0, 0], "description": "[m]"},
            "u": {"$ref": "#/definitions/vec3", "default": [1, 0, 0]},
            "v": {"$ref": "#/definitions/vec3", "default": [0, 1, 0]}
          }
        },
        "velocity": {"$ref": "#/definitions/vec3", "default": [0, 0, 0], "description": "at the start [m/s]"},
        "material": {
          "description": "the name of a shipped material, or its numbers",
          "type": ["string", "object"],
          "additionalProperties": false,
          "properties": {
            "density": {"type": "number", "exclusiveMinimum": 0, "default": 0.05, "description": "[kg/m^2]"},
            "youngs": {"type": "number", "exclusiveMinimum": 0, "default": 50,
                       "description": "2-D modulus, thickness folded in [N/m]"},
            "poisson": {"type": "number", "minimum": 0, "exclusiveMaximum": 0.5, "default": 0.3},
            "bending": {"type": "number", "minimum": 0, "default": 1e-5, "description": "plate stiffness [J]"},
            "damping": {"type": "number", "minimum": 0, "default": 0,
                        "description": "stiffness-proportional: force = damping K v [s]"}
          }
        },
        "remeshing": {
          "type": "object",
          "default": {},
          "additionalProperties": false,
          "properties": {
            "method": {"enum": ["none", "adaptive", "conformal"], "default": "none"},
            "size": {"type": "array", "items": {"type": "number", "exclusiveMinimum": 0}, "minItems": 2,
                     "maxItems": 2, "description": "shortest and longest edge [m]"},
            "angle": {"type": "number", "exclusiveMinimum": 0, "default": 0.3,
                      "description": "normal change along an edge [rad]"},
            "velocity": {"type": "number", "exclusiveMinimum": 0, "default": 0.5,
                         "description": "velocity difference along an edge [m/s]"},
            "compression": {"type": "number", "exclusiveMinimum": 0, "default": 0.005,
                            "description": "amplitude of the wrinkle that takes up a compression [m]"},
            "aspect": {"type": "number", "exclusiveMinimum": 0, "maximum": 1, "default": 0.2,
                       "description": "smallest ratio of the metric's two lengths"}
          }
        },
        "pins": {"type": "array", "maxItems": 64, "default": [], "items": {"$ref": "#/definitions/pin"}}
      }
    },
    "pin": {
      "type": "object",
      "additionalProperties": false,
      "required": ["where"],
      "properties": {
        "where": {
          "type": "object",
          "additionalProperties": false,
          "oneOf": [{"required": ["corner"]}, {"required": ["edge"]}, {"required": ["material"]},
                    {"required": ["vertices"]}],
          "properties": {
            "corner": {"enum": ["00", "10", "11", "01"], "description": "U end, V end"},
            "edge": {"enum": ["u0", "u1", "v0", "v1"]},
            "material": {"$ref": "#/definitions/vec2", "description": "the vertex nearest to [U, V] [m]"},
            "vertices": {"type": "array", "minItems": 1,
                         "items": {"type": "integer", "minimum": 0, "maximum": 2147483647},
                         "description": "numbers from 0"}
          }
        },
        "axes": {"enum": ["xyz", "xy", "xz", "yz", "x", "y", "z"], "default": "xyz"},
        "motion": {
          "type": "array",
          "default": [],
          "items": {
            "type": "object",
            "additionalProperties": false,
            "required": ["time"],
            "properties": {
              "time": {"type": "number", "minimum": 0, "description": "[s]"},
              "velocity": {"$ref": "#/definitions/vec3", "default": [0, 0, 0],
                           "description": "holds until the next entry [m/s]"}
            }
          }
        },
        "ramp": {"type": "number", "minimum": 0, "default": 0, "description": "smooths each change of velocity [s]"},
        "release": {"type": "number", "minimum": 0, "description": "lets go at this time [s]"}
      }
    },
    "obstacle": {
      "type": "object",
      "additionalProperties": false,
      "oneOf": [{"required": ["box"]}, {"required": ["point"]}, {"required": ["wire"]}, {"required": ["mesh"]}],
      "properties": {
        "name": {"$ref": "#/definitions/label"},
        "box": {
          "type": "object",
          "additionalProperties": false,
          "required": ["size"],
          "properties": {
            "size": {"type": "array", "items": {"type": "number", "exclusiveMinimum": 0}, "minItems": 3, "maxItems": 3,
                     "description": "[m]"}
          }
        },
        "point": {
          "type": "object",
          "additionalProperties": false,
          "properties": {
            "normal": {"$ref": "#/definitions/vec3", "default": [0, 0, 1],
                       "description": "to the side that the cloth is on; any length but 0"}
          }
        },
        "wire": {
          "type": "object",
          "additionalProperties": false,
          "required": ["points"],
          "properties": {
            "points": {"type": "array", "minItems": 2, "items": {"$ref": "#/definitions/vec3"},
                       "description": "polyline, local coordinates [m]"}
          }
        },
        "mesh": {
          "type": "object",
          "additionalProperties": false,
          "required": ["file"],
          "properties": {
            "file": {"type": "string", "description": "closed triangle mesh, OBJ"},
            "sharp_angle": {"type": "number", "exclusiveMinimum": 0, "maximum": 180, "default": 30,
                            "description": "edges sharper than this are features [degrees]"}
          }
        },
        "position": {"$ref": "#/definitions/vec3", "default": [0, 0, 0], "description": "[m]"},
        "rotation": {
          "type": "object",
          "default": {},
          "additionalProperties": false,
          "properties": {
            "axis": {"$ref": "#/definitions/vec3", "default": [0, 0, 1]},
            "degrees": {"type": "number", "default": 0}
          }
        },
        "motion": {
          "type": "array",
          "default": [],
          "items": {
            "type": "object",
            "additionalProperties": false,
            "required": ["time"],
            "properties": {
              "time": {"type": "number", "minimum": 0, "description": "[s]"},
              "velocity": {"$ref": "#/definitions/vec3", "default": [0, 0, 0],
                           "description": "holds until the next entry [m/s]"},
              "angular_velocity": {"$ref": "#/definitions/vec3", "default": [0, 0, 0],
                                   "description": "about the obstacle's own position, world axes [rad/s]"}
            }
          }
        }
      }
    }
  }
}
)json";

}  // namespace

std::string scene_schema() {
  return schema_text;
}

}  // namespace crease
