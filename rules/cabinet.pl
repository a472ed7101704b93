% Made from cabinet.model by `facetlog model compile`; not to be edited by hand.
% After a change of the model run `make models`.
:- module(cabinet, []).
:- use_module(facetlog(vocabulary)).
% cabinet.model:5
model(cabinet,
      "A closed upright block on the floor, higher than deep, on a plinth, feet or its own sides.",
      [top, front, side]).

% cabinet.model:14  parts
candidate(cabinet, Thing, Parts) :-
    findall(Parts, likely(cabinet, Thing, Parts), Found),
    ( Found == [] -> distant(cabinet, Thing, Parts) ; member(Parts, Found) ).

% cabinet.model:14  all that may satisfy its lines
likely(cabinet, Thing, [Top, Front, Side]) :-
    face_of(Thing, Top),
    possible(all([measured(Top), level(Top), upward(Top), at_least(share(Top), 0.8),
                  at_least(fill(Top), 0.8), at_most(protrusion(Top), 0.05*thing_length(Thing)),
                  at_most(clear_below(Top), 0.4*elevation(Top)),
                  at_least(thing_height(Thing), 1.2*width(Top))])),
    shared_edge(Top, Front, _),
    possible(all([measured(Front), upright(Front), at_least(share(Front), 0.6),
                  at_least(fill(Front), 0.8),
                  at_most(protrusion(Front), 0.05*thing_length(Thing)),
                  at_most(bottom_of(Front), 0.4*thing_height(Thing))])),
    possible(all([near(angle(Top, Front), 90, 15), convex(Top, Front)])),
    shared_edge(Top, Side, _),
    Front @< Side,
    shared_edge(Front, Side, _),
    possible(all([measured(Side), upright(Side), at_least(share(Side), 0.6),
                  at_least(fill(Side), 0.8),
                  at_most(protrusion(Side), 0.05*thing_length(Thing)),
                  at_most(bottom_of(Side), 0.4*thing_height(Thing))])),
    possible(all([near(angle(Top, Side), 90, 15), near(angle(Front, Side), 90, 15),
                  convex(Top, Side), convex(Front, Side)])).

% cabinet.model:14  near misses
distant(cabinet, Thing, [Top, Front2, Side2]) :-
    largest_faces(Thing, Faces),
    limit(40,
          ( member(Top, Faces), shared_edge(Top, Front, _), shared_edge(Top, Side, _),
            Front @< Side, shared_edge(Front, Side, _) )),
    msort([Front, Side], [Front2, Side2]).
% cabinet.model:14  near misses
distant(cabinet, Thing, [Top, Front2, Side2]) :-
    \+ ( face_of(Thing, Top), possible(all([measured(Top), level(Top), upward(Top)])),
         shared_edge(Top, Front, _),
         possible(all([measured(Front), upright(Front), near(angle(Top, Front), 90, 15)])),
         shared_edge(Top, Side, _), Front @< Side, shared_edge(Front, Side, _),
         possible(all([measured(Side), upright(Side), near(angle(Top, Side), 90, 15),
                       near(angle(Front, Side), 90, 15)])) ),
    as_far_as_seen(Thing,
                   [step(Top, 6, all([measured(Top), level(Top), upward(Top)])),
                    step(Front, 3,
                         all([measured(Front), upright(Front), near(angle(Top, Front), 90, 15)])),
                    step(Side, 3,
                         all([measured(Side), upright(Side), near(angle(Top, Side), 90, 15),
                              near(angle(Front, Side), 90, 15)]))],
                   [Top, Front, Side]),
    msort([Front, Side], [Front2, Side2]).

% cabinet.model:15  leg is upright, bottom_of(leg) at most 5 % of height(this), top_of(leg) between 3 % of height(this) and 40 % of height(this)
means('cabinet.leg'(Leg, Thing),
      all([upright(Leg), soft(at_most(bottom_of(Leg), 0.05*thing_height(Thing)), 0.1),
           soft(between(top_of(Leg), 0.03*thing_height(Thing), 0.4*thing_height(Thing)), 0.1)])).

% cabinet.model:15
members(cabinet, leg, Thing, [Top, Front, Side], Members) :-
    findall(Leg,
            ( element_of(Thing, Leg), \+ memberchk(Leg, [Top, Front, Side]),
              possible('cabinet.leg'(Leg, Thing)) ), Found),
    sort(Found, Members).

% cabinet.model:19  top is measured, top is level, top is upward
condition(cabinet, level, "the top is level and faces up", _, [Top, _, _],
          all([measured(Top), level(Top), upward(Top)])).
% cabinet.model:20  each x of front, side: x is measured, x is upright
condition(cabinet, upright, "two of its sides are upright", _, [_, Front, Side],
          each(X, [Front, Side], all([measured(X), upright(X)]))).
% cabinet.model:21  each pair x, y of top, front, side: x adjoins y
condition(cabinet, adjoining, "each two of the faces share an edge", _, [Top, Front, Side],
          each_pair(X, Y, [Top, Front, Side], adjoins(X, Y))).
% cabinet.model:22  each pair x, y of top, front, side: angle(x, y) = 90 deg ± right
condition(cabinet, square, "the faces meet at right angles", _, [Top, Front, Side],
          each_pair(X, Y, [Top, Front, Side], soft(near(angle(X, Y), 90, 15), 0.1))).
% cabinet.model:24  each pair x, y of top, front, side: convex(x, y)
condition(cabinet, convex, "the faces bulge outwards where they meet", _, [Top, Front, Side],
          each_pair(X, Y, [Top, Front, Side], convex(X, Y))).
% cabinet.model:26  share(top) at least 80 %
condition(cabinet, cover, "the top covers it seen from above", _, [Top, _, _],
          soft(at_least(share(Top), 0.8), 0.1)).
% cabinet.model:27  each x of front, side: share(x) at least 100 % - base
condition(cabinet, closed, "the sides are closed, down to the feet", _, [_, Front, Side],
          each(X, [Front, Side], soft(at_least(share(X), 0.6), 0.1))).
% cabinet.model:28  each x of top, front, side: fill(x) at least 80 %
condition(cabinet, whole, "each face is a whole rectangle", _, [Top, Front, Side],
          each(X, [Top, Front, Side], soft(at_least(fill(X), 0.8), 0.1))).
% cabinet.model:29  each x of top, front, side: protrusion(x) at most 5 % of length(this)
condition(cabinet, flush, "nothing sticks out past a face", Thing, [Top, Front, Side],
          each(X, [Top, Front, Side],
               soft(at_most(protrusion(X), 0.05*thing_length(Thing)), 0.1))).
% cabinet.model:31  clear_below(top) at most base * elevation(top)
condition(cabinet, solid, "there is no free space beneath the top but for feet", _, [Top, _, _],
          soft(at_most(clear_below(Top), 0.4*elevation(Top)), 0.1)).
% cabinet.model:32  each x of front, side: bottom_of(x) at most base * height(this)
condition(cabinet, standing, "the sides go down to the floor or nearly so", Thing,
          [_, Front, Side],
          each(X, [Front, Side], soft(at_most(bottom_of(X), 0.4*thing_height(Thing)), 0.1))).
% cabinet.model:33  height(this) at least 120 % of width(top)
condition(cabinet, tall, "it is higher than deep", Thing, [Top, _, _],
          soft(at_least(thing_height(Thing), 1.2*width(Top)), 0.1)).
% cabinet.model:34  each face other where area(other) at least 5 % of area(top): lies_along(other)
condition(cabinet, others, "every other face lies along one of the three", Thing,
          [Top, Front, Side],
          each(Other, Others,
               implies(soft(at_least(area(Other), 0.05*area(Top)), 0.1),
                       any([parallel(Other, Top, 15), parallel(Other, Front, 15),
                            parallel(Other, Side, 15)])))) :-
    findall(Other,
            ( face_of(Thing, Other), \+ memberchk(Other, [Top, Front, Side]),
              possible(at_least(area(Other), 0.05*area(Top))) ), Found),
    sort(Found, Others).
% cabinet.model:35  each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright
condition(cabinet, straight, "its large faces are level or upright", Thing, [Top, Front, Side],
          each(F, Fs,
               implies(soft(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing)), 0.1),
                       any([level(F), upright(F)])))) :-
    findall(F,
            ( face_of(Thing, F), \+ memberchk(F, [Top, Front, Side]),
              possible(at_least(area(F), 0.2*thing_length(Thing)*thing_width(Thing))) ),
            Found),
    sort(Found, Fs).
% cabinet.model:37  count(leg) at least 1
condition(cabinet, raised, "cabinets stand on a plinth or feet", Thing, [Top, Front, Side],
          expect(0.1, at_least_of(1, Leg, Leg_groups, 'cabinet.leg'(Leg, Thing)))) :-
    members(cabinet, leg, Thing, [Top, Front, Side], Leg_members),
    separate(Leg_members, Leg_groups).
% cabinet.model:38  height(this) between 50 cm and 260 cm
condition(cabinet, usual, "cabinets are 50 cm to 260 cm high", Thing, [_, _, _],
          expect(0.5,
                 if_known(soft(between(thing_height(Thing), metres(0.5), metres(2.6)), 0.1)))).

written(cabinet, level, 'cabinet.model:19', "top is measured, top is level, top is upward").
written(cabinet, upright, 'cabinet.model:20',
        "each x of front, side: x is measured, x is upright").
written(cabinet, adjoining, 'cabinet.model:21',
        "each pair x, y of top, front, side: x adjoins y").
written(cabinet, square, 'cabinet.model:22',
        "each pair x, y of top, front, side: angle(x, y) = 90 deg ± right").
written(cabinet, convex, 'cabinet.model:24', "each pair x, y of top, front, side: convex(x, y)").
written(cabinet, cover, 'cabinet.model:26', "share(top) at least 80 %").
written(cabinet, closed, 'cabinet.model:27',
        "each x of front, side: share(x) at least 100 % - base").
written(cabinet, whole, 'cabinet.model:28', "each x of top, front, side: fill(x) at least 80 %").
written(cabinet, flush, 'cabinet.model:29',
        "each x of top, front, side: protrusion(x) at most 5 % of length(this)").
written(cabinet, solid, 'cabinet.model:31', "clear_below(top) at most base * elevation(top)").
written(cabinet, standing, 'cabinet.model:32',
        "each x of front, side: bottom_of(x) at most base * height(this)").
written(cabinet, tall, 'cabinet.model:33', "height(this) at least 120 % of width(top)").
written(cabinet, others, 'cabinet.model:34',
        "each face other where area(other) at least 5 % of area(top): lies_along(other)").
written(cabinet, straight, 'cabinet.model:35',
        "each face f where area(f) at least 20 % of length(this) * width(this): f is level or f is upright").
written(cabinet, raised, 'cabinet.model:37', "count(leg) at least 1").
written(cabinet, usual, 'cabinet.model:38', "height(this) between 50 cm and 260 cm").

% cabinet.model:15
group(cabinet, Thing, [Top, Front, Side], leg, Members) :-
    members(cabinet, leg, Thing, [Top, Front, Side], Leg_members),
    findall(Leg, ( member(Leg, Leg_members), holds('cabinet.leg'(Leg, Thing)) ), Members).

% cabinet.model:40
size(cabinet, _, [Top, _, _], width, length(Top)).
% cabinet.model:41
size(cabinet, _, [Top, _, _], depth, width(Top)).
% cabinet.model:42
size(cabinet, Thing, [_, _, _], height, thing_height(Thing)).
