:- module(facetlog_sight, [ sight/2,          % +Thing, -Sight
                            others_near/2     % +Thing, -Others
                          ]).

/** <module> From where a thing was seen

What an explanation of what was not seen rests on, in the facts' own numbers.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(aggregate)).
:- use_module(library(pairs)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog(vocabulary), [measure/4, holds/1]).

%!  sight(+Thing, -Sight) is det.
%
%   Sight is sight(Whole, Ups, Points, Places, Normals, Implied, Open, Assumed, Filled, Gaps) of a thing
%   of the current scene:
%
%     - Whole is true where its surface is known from all sides, else false;
%     - Ups is a list of at most one at(X, Y, Z), the unit vector upwards;
%     - Points are the places at(X, Y, Z) of the vertices of its faces and loose edges;
%     - Places are from(Name, Picture, at(X, Y, Z), Counts) of viewpoints; Counts is [Count], how many
%       of those vertices the view saw, and [] where a scanner stood;
%     - Normals are the outward normals at(X, Y, Z) of its measured faces;
%     - Implied are implied(Face, Normal, Shown) of its other faces; Shown is a list of
%       shows(View, Seen, Outside, Hidden), Hidden of By-Share;
%     - Open are at(X, Y, Z)-Share: so much of the unseen space round it would show from there;
%     - Assumed is the share of what it fills that is only taken to be full;
%     - Filled is the share of its volume that its pieces fill, 1 where nobody asks for pieces, and Gaps
%       are corners at(X, Y, Z)-at(X, Y, Z), lowest and highest, of boxes round what none fills.

sight(Thing, sight(Whole, Ups, Points, Places, Normals, Implied, Open, Assumed, Filled, Gaps)) :-
    ( fact(whole(Thing)) -> Whole = true ; Whole = false ),
    findall(at(X, Y, Z), fact(up(X, Y, Z)), Ups),
    findall(V, vertex_of(Thing, V), Vs0),
    sort(Vs0, Vs),
    findall(at(X, Y, Z), ( member(V, Vs), fact(point(V, X, Y, Z)) ), Points),
    findall(from(P, Picture, at(X, Y, Z), Counts),
            ( fact(viewpoint(P, X, Y, Z)), seen_from(P, Vs, Picture, Counts) ),
            Places),
    findall(Normal, ( face_of(Thing, Face, measured), normal(Face, Normal) ), Normals),
    findall(implied(Face, Normal, Shown),
            ( face_of(Thing, Face, implied), normal(Face, Normal), shown(Face, Shown) ),
            Implied),
    findall(at(X, Y, Z)-Share, fact(unseen_towards(Thing, X, Y, Z, Share)), Open),
    ( fact(assumed_full(Thing, Assumed)) -> true ; Assumed = 0 ),
    ( fact(explained(Thing, Filled)) -> true ; Filled = 1 ),
    findall(at(A, B, C)-at(D, E, F), fact(unexplained(Thing, A, B, C, D, E, F)), Gaps).

vertex_of(Thing, V) :-
    fact(part_of(Part, Thing)),
    (   fact(corner(Part, _, V))
    ;   fact(edge(Part, V, _))
    ;   fact(edge(Part, _, V))
    ).

seen_from(View, Vs, Picture, [Count]) :-
    fact(view(View, Picture)),
    !,
    findall(V, ( member(V, Vs), fact(observed(V, View, _, _, _, _)) ), Seen),
    length(Seen, Count).
seen_from(Place, _, Place, []).

face_of(Thing, Face, Evidence) :-
    fact(part_of(Face, Thing)),
    fact(face(Face)),
    fact(evidence(Face, Evidence)).

normal(Face, at(A, B, C)) :-
    fact(plane(Face, A, B, C, _)).

shown(Face, Shown) :-
    findall(shows(View, Seen, Outside, Hidden),
            ( fact(shows(View, Face, Seen, Outside)),
              findall(By-Share, fact(hides(View, Face, By, Share)), Hidden) ),
            Shown).

%!  others_near(+Thing, -Others) is det.
%
%   Others are other(Name, Shapes) of the things that are no further away than Thing is long, the nearest
%   first; Shapes are counted(Shape, Count) of their pieces.

others_near(Thing, Others) :-
    findall(Gap-other(Other, Shapes),
            ( measure(thing_length(Thing), Length, _, _),
              ( fact(gap(Thing, Other, Gap, _)) ; fact(gap(Other, Thing, Gap, _)) ),
              Gap =< Length,
              shapes_of(Other, Shapes) ),
            Found),
    sort(0, @=<, Found, Sorted),
    pairs_values(Sorted, All),
    list_to_set(All, Others).

shapes_of(Thing, Shapes) :-
    findall(counted(Shape, Count),
            ( member(Shape-Test, [board-board(P), bar-bar(P), block-block(P)]),
              aggregate_all(count, ( fact(piece_of(P, Thing)), holds(Test) ), Count),
              Count > 0 ),
            Shapes).
