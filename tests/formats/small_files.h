// SPDX-License-Identifier: MIT
#pragma once

#include <string>

/// Characters of a few lines in text formats, for tests.
namespace skinlod {

/// A quad of MD5 with two joints. Vertex 2 follows both, half and half.
inline const std::string kSmallMd5 = R"(MD5Version 10
commandline ""

numJoints 2
numMeshes 1

joints {
	"root"	-1 ( 0 0 0 ) ( 0 0 0 )
	"tip"	0 ( 0 0 1 ) ( 0 0 0 )
}

mesh {
	shader "skin"

	numverts 4
	vert 0 ( 0 0 ) 0 1
	vert 1 ( 1 0 ) 1 1
	vert 2 ( 1 1 ) 2 2
	vert 3 ( 0 1 ) 4 1

	numtris 2
	tri 0 0 1 2
	tri 1 0 2 3

	numweights 5
	weight 0 0 1 ( 0 0 0 )
	weight 1 0 1 ( 1 0 0 )
	weight 2 0 0.5 ( 1 0 1 )
	weight 3 1 0.5 ( 1 0 0 )
	weight 4 1 1 ( 0 0 0 )
}
)";

/// DirectX X: the node that carries the mesh and the joint it follows are both called "Bone".
inline const std::string kClashingX = R"(xof 0303txt 0032
Frame Root {
  FrameTransformMatrix { 1.0,0.0,0.0,0.0, 0.0,1.0,0.0,0.0, 0.0,0.0,1.0,0.0, 0.0,0.0,0.0,1.0;; }
  Frame Bone {
    FrameTransformMatrix { 1.0,0.0,0.0,0.0, 0.0,1.0,0.0,0.0, 0.0,0.0,1.0,0.0, 5.0,0.0,0.0,1.0;; }
    Mesh {
      4;
      0.0;0.0;0.0;, 1.0;0.0;0.0;, 1.0;1.0;0.0;, 0.0;1.0;0.0;;
      1;
      4;0,1,2,3;;
      XSkinMeshHeader { 1; 1; 1; }
      SkinWeights {
        "Bone"; 4; 0, 1, 2, 3; 1.0, 1.0, 1.0, 1.0;
        1.0,0.0,0.0,0.0, 0.0,1.0,0.0,0.0, 0.0,0.0,1.0,0.0, 0.0,-2.0,0.0,1.0;;
      }
    }
  }
  Frame Bone {
    FrameTransformMatrix { 1.0,0.0,0.0,0.0, 0.0,1.0,0.0,0.0, 0.0,0.0,1.0,0.0, 0.0,2.0,0.0,1.0;; }
  }
}
AnimationSet Wave {
  Animation {
    { Bone }
    AnimationKey { 2; 2; 0;3;0.0,2.0,0.0;;, 4800;3;0.0,3.0,0.0;;; }
  }
}
)";

/// Collada in centimetres, Z up: a quad on "hip" and "knee" (one metre up each), a prop at two nodes of which
/// one hangs from the knee, and a clip of one second that moves the knee up by half a metre.
inline const std::string kSmallCollada = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries>
<geometry id="quad"><mesh>
<source id="qp"><float_array id="qpa" count="12">0 0 100 50 0 100 50 0 200 0 0 200</float_array><technique_common>
<accessor source="#qpa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="qt"><float_array id="qta" count="8">0 0 1 0 1 1 0 0.75</float_array><technique_common>
<accessor source="#qta" count="4" stride="2"><param name="S" type="float"/><param name="T" type="float"/>
</accessor></technique_common></source>
<vertices id="qv"><input semantic="POSITION" source="#qp"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#qv" offset="0"/>
<input semantic="TEXCOORD" source="#qt" offset="1" set="0"/><vcount>4</vcount><p>0 0 1 1 2 2 3 3</p></polylist>
</mesh></geometry>
<geometry id="prop"><mesh>
<source id="pp"><float_array id="ppa" count="9">0 0 0 10 0 0 0 0 10</float_array><technique_common>
<accessor source="#ppa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="pv"><input semantic="POSITION" source="#pp"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#pv" offset="0"/><vcount>3</vcount><p>0 1 2</p></polylist>
</mesh></geometry>
</library_geometries>
<library_controllers><controller id="skin"><skin source="#quad">
<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>
<source id="sj"><Name_array id="sja" count="2">hip knee</Name_array><technique_common>
<accessor source="#sja" count="2" stride="1"><param name="JOINT" type="name"/></accessor></technique_common></source>
<source id="sb"><float_array id="sba" count="32">1 0 0 0 0 1 0 0 0 0 1 -100 0 0 0 1
1 0 0 0 0 1 0 0 0 0 1 -200 0 0 0 1</float_array><technique_common>
<accessor source="#sba" count="2" stride="16"><param name="TRANSFORM" type="float4x4"/></accessor>
</technique_common></source>
<source id="sw"><float_array id="swa" count="2">1 0.25</float_array><technique_common>
<accessor source="#swa" count="2" stride="1"><param name="WEIGHT" type="float"/></accessor></technique_common></source>
<joints><input semantic="JOINT" source="#sj"/><input semantic="INV_BIND_MATRIX" source="#sb"/></joints>
<vertex_weights count="4"><input semantic="JOINT" source="#sj" offset="0"/>
<input semantic="WEIGHT" source="#sw" offset="1"/><vcount>1 1 1 2</vcount><v>0 0 0 0 1 0 1 0 0 1</v></vertex_weights>
</skin></controller></library_controllers>
<library_animations><animation id="move">
<source id="ai"><float_array id="aia" count="2">0 1</float_array><technique_common>
<accessor source="#aia" count="2" stride="1"><param name="TIME" type="float"/></accessor></technique_common></source>
<source id="ao"><float_array id="aoa" count="6">0 0 100 0 0 150</float_array><technique_common>
<accessor source="#aoa" count="2" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="an"><Name_array id="ana" count="2">LINEAR LINEAR</Name_array><technique_common>
<accessor source="#ana" count="2" stride="1"><param name="INTERPOLATION" type="name"/></accessor>
</technique_common></source>
<sampler id="as"><input semantic="INPUT" source="#ai"/><input semantic="OUTPUT" source="#ao"/>
<input semantic="INTERPOLATION" source="#an"/></sampler>
<channel source="#as" target="knee/place"/></animation></library_animations>
<library_visual_scenes><visual_scene id="scene">
<node id="hip" sid="hip" type="JOINT"><translate sid="place">0 0 100</translate>
<node id="knee" sid="knee" type="JOINT"><translate sid="place">0 0 100</translate>
<node id="hung"><translate>20 0 0</translate><instance_geometry url="#prop"/></node></node></node>
<node id="body"><instance_controller url="#skin"><skeleton>#hip</skeleton></instance_controller></node>
<node id="stood"><translate>-100 0 0</translate><instance_geometry url="#prop"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
)";

/// `text` with the first `from` in it made `to`; empty where there is none, so that no test runs on nothing.
inline std::string edited(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  return at == std::string::npos ? "" : text.replace(at, from.size(), to);
}

}  // namespace skinlod
