:- module(facetlog_near_miss, [ why/5,        % +Module, +Model, +Things, +Given, -Explained
                                why_not/6     % +Module, +Model, +Things, +Given, +Count, -Verdicts
                              ]).

/** <module> The best answer that agrees with what was given, and what comes near

Given is a list of Role-Face: what the asker says about the parts, and what `why` is asked of the
members of sets. Verdicts have what comes nearest to sets (members.pl). Things is a list of the things
that are meant, or `all`. Assignments that no candidate/3 proposes are judged all the same if
the asker names them.
*/

:- use_module(library(lists)).
:- use_module(library(apply)).
:- use_module(library(pairs)).
:- use_module(library(error)).
:- use_module(facetlog_kb(scene)).
:- use_module(facetlog_kb(judge)).
:- use_module(facetlog_kb(code)).
:- use_module(facetlog_kb(in_progress)).
:- use_module(facetlog_kb(search)).
:- use_module(facetlog_kb(members)).
:- use_module(facetlog(vocabulary)).

:- meta_predicate must_exist(0, +, +),
                  must_exist(0, +, +, 1).

%!  why(+Module, +Model, +Things, +Given, -Explained) is det.
%
%   Explained is explained(Verdict, Asked) on the best assignment that agrees with Given; Asked has what
%   asked_member/7 says of each Role-Face of Given where Role is a set.
%
%   @error existence_error(Kind, Name) if the scene has no such thing or part, or the model no such
%          role.

why(Module, Model, Things, Given, Explained) :-
    with_code(Module, Model, Target, explained(Target, Module, Model, Things, Given, Explained)).

explained(Target, Module, Model, Things, Given0, explained(Verdict, Asked)) :-
    set_roles(Module, Model, Sets),
    partition(of_set(Sets), Given0, Members, Given),
    meant_things(Module, Model, Things, Given0, Sets, Meant),
    agreeing(Meant, Target, Module, Model, Given, Candidates),
    best_of(Target, Model, Candidates, Best),
    (   Best = best(_, Thing, Parts, _)
    ->  maplist(asked_in(Module, Model, Thing, Parts), Members, Asked)
    ;   ( Meant = [Thing|_] -> true ; Thing = '' ),     % the scene has nothing
        Asked = []
    ),
    verdict_of(Best, Module, Model, Thing, Verdict0),
    add_near(Module, Verdict0, Verdict).

of_set(Sets, Role-_) :-
    memberchk(Role, Sets).

asked_in(Module, Model, Thing, Parts, Role-Name, Asked) :-
    asked_member(Module, Model, Thing, Parts, Role, Name, Asked).

%!  why_not(+Module, +Model, +Things, +Given, +Count, -Verdicts) is det.
%
%   Verdicts are on the at most Count nearest assignments that agree with Given and do not hold, the
%   nearest first, in the order of search.pl. Of a thing that fails, the first is what judge/4 shows.
%   Where none can hold, only those are looked at among which judge/4 finds what it shows.
%
%   @error as why/5, and existence_error(single_part, Role) for a Role that is a set

why_not(Module, Model, Things, Given, Count, Verdicts) :-
    with_code(Module, Model, Target, misses(Target, Module, Model, Things, Given, Count, Verdicts)).

misses(Target, Module, Model, Things, Given, Count, Verdicts) :-
    set_roles(Module, Model, Sets),
    forall(member(Role-_, Given), must_exist(\+ memberchk(Role, Sets), single_part, Role)),
    meant_things(Module, Model, Things, Given, [], Meant),
    agreeing(Meant, Target, Module, Model, Given, Candidates0),
    looked_further(Candidates0, Module, Model, Given, Candidates),
    Target:plan(Model, Plan),
    start(miss, Candidates, Plan, Queue),
    nearest(Count, Queue, Misses),
    maplist(prove_miss(Module, Model), Misses, Verdicts).

prove_miss(Module, Model, found(Thing, Parts, _), Verdict) :-
    prove(Module, Model, Thing, Parts, 0, Verdict0),
    add_near(Module, Verdict0, Verdict).

nearest(Count, Queue0, Misses) :-
    (   Count > 0,
        next_best(miss, Queue0, Queue, Found)
    ->  (   in_all(Found, holds)
        ->  Misses = Rest,
            Left = Count
        ;   Misses = [Found|Rest],
            Left is Count - 1
        ),
        nearest(Left, Queue, Rest)
    ;   Misses = []
    ).

                 /*******************************
                 *         WHAT IS MEANT        *
                 *******************************/

%   The things that can be meant; Sets are roles beside the model's parts.
meant_things(Module, Model, Things, Given, Sets, Meant) :-
    once(Module:model(Model, _, Singles)),
    append(Singles, Sets, Roles),
    forall(member(Role-_, Given), must_exist(memberchk(Role, Roles), role, Role, =(Roles))),
    forall(member(_-Part, Given), must_exist(known_part(Part), part, Part, known_parts)),
    (   Things == all
    ->  findall(Thing, things_of(Given, Thing), Bag),
        sort(Bag, Meant)
    ;   forall(member(Thing, Things), must_exist(fact(thing(Thing)), thing, Thing)),
        Meant = Things
    ).

must_exist(Goal, Kind, Name) :-
    (   call(Goal)
    ->  true
    ;   existence_error(Kind, Name)
    ).

%   The error says in its context what there is.
must_exist(Goal, Kind, Name, Names) :-
    (   call(Goal)
    ->  true
    ;   call(Names, There),
        throw(error(existence_error(Kind, Name), there(There)))
    ).

known_parts(Parts) :-
    findall(Face, fact(face(Face)), Faces),
    findall(Edge, fact(edge(Edge, _, _)), Edges),
    findall(Piece, fact(piece(Piece)), Pieces),
    findall(Opening, fact(opening(Opening)), Openings),
    findall(Hollow, fact(hollow_of(Hollow, _)), Hollows),
    convlist(span, [Faces, Edges, Pieces, Openings, Hollows], Parts).

%   Names that count up, in short; fails where there are none.
span([Only], Only) :- !.
span([First|Rest], Span) :-
    last(Rest, Last),
    format(atom(Span), "~w to ~w", [First, Last]).

known_part(unseen) :- !.
known_part(Part) :- fact(face(Part)), !.
known_part(Part) :- fact(edge(Part, _, _)), !.
known_part(Part) :- fact(piece(Part)), !.
known_part(Part) :- fact(opening(Part)), !.
known_part(Part) :- fact(hollow_of(Part, _)), !.
known_part(Part) :- fact(thing(Part)).

things_of(Given, Thing) :-
    (   member(_-Part, Given),
        belongs(Part, _)
    ->  member(_-Other, Given),
        belongs(Other, Thing)
    ;   fact(thing(Thing))
    ).

belongs(Part, Thing) :- fact(part_of(Part, Thing)).
belongs(Part, Thing) :- fact(piece_of(Part, Thing)).
belongs(Part, Thing) :- fact(opening_of(Part, Thing)).
belongs(Part, Thing) :- fact(hollow_of(Part, Thing)).

%   What the model proposes and agrees with Given; else what it proposes, with Given put in its place;
%   else Given alone.
agreeing(Things, Target, Module, Model, Given, Candidates) :-
    once(Module:model(Model, _, Roles)),
    findall(Candidate,
            ( member(Thing, Things),
              while_judging(Module, Model, Thing, proposed(Given, Target, Module, Model, Thing, Proposed)),
              agreeing_with(Given, Roles, Thing, Proposed, Agreed),
              member(Candidate, Agreed) ),
            Bag),
    sort(Bag, Candidates).

proposed([], Target, Module, Model, Thing, Proposed) :-
    !,
    considered(Target, Module, Model, Thing, Proposed).
proposed(_, Target, _, Model, Thing, Proposed) :-
    candidates(Target, Model, Thing, Proposed).

agreeing_with(Given, Roles, Thing, Proposed, Agreed) :-
    include(agrees(Given, Roles), Proposed, Agreed0),
    (   Agreed0 \== []
    ->  Agreed = Agreed0
    ;   findall(Thing-Parts,
                ( member(_-Parts0, Proposed),
                  put_in(Roles, Given, Parts0, Parts) ),
                Put),
        Put \== []
    ->  sort(Put, Agreed)
    ;   unseen_parts(Roles, Parts0),
        maplist(given_part(Given), Roles, Parts0, Parts),
        Agreed = [Thing-Parts]
    ).

agrees(Given, Roles, _-Parts) :-
    pairs_keys_values(Roled, Roles, Parts),
    forall(member(Role-Face, Given),
           ( memberchk(Role-Part, Roled),
             plays_in(Face, Part) )).

plays_in(Face, Part) :-
    (   is_list(Part)
    ->  memberchk(Face, Part)
    ;   Face == Part
    ).

%   No face may stand in two places: where one that is given stood, there comes what stood in its place.
put_in(Roles, Given, Parts0, Parts) :-
    foldl(put_one(Roles), Given, Parts0, Parts),
    include(atom, Parts, Single0),
    exclude(==(unseen), Single0, Single),
    sort(Single, Different),
    same_length(Single, Different).

put_one(Roles, Role-Face, Parts0, Parts) :-
    nth1(Place, Roles, Role),
    nth1(Place, Parts0, Part0),
    ( is_list(Part0) -> Instead = unseen ; Instead = Part0 ),
    maplist(exchanged(Face, Instead), Parts0, Parts1),
    given_part([Role-Face], Role, Part0, Part),
    nth1(Place, Parts1, _, Others),
    nth1(Place, Parts, Part, Others).

exchanged(Face, Instead, Part0, Part) :-
    ( Part0 == Face -> Part = Instead ; Part = Part0 ).

given_part(Given, Role, Part0, Part) :-
    (   memberchk(Role-Face, Given)
    ->  ( is_list(Part0) -> Part = [Face] ; Part = Face )
    ;   Part = Part0
    ).

unseen_parts(Roles, Parts) :-
    maplist(unseen_part, Roles, Parts).

unseen_part(_, unseen).

%   Where nothing was found that could be a part, the faces that are there are tried as the first
%   one, which a model names first because the rest is found from it: they say what is wrong.
looked_further(Candidates0, Module, Model, Given, Candidates) :-
    findall(Thing-Parts,
            ( member(Thing-Unseen, Candidates0),
              forall(member(Part, Unseen), Part == unseen),
              once(Module:model(Model, _, [First|Roles])),
              \+ memberchk(First-_, Given),
              face_of(Thing, Face),
              unseen_parts(Roles, Rest),
              Parts = [Face|Rest] ),
            Tried),
    (   Tried == []
    ->  Candidates = Candidates0
    ;   exclude(tried_in(Tried), Candidates0, Kept),
        append(Kept, Tried, Both),
        sort(Both, Candidates)
    ).

tried_in(Tried, Thing-Parts) :-
    maplist(==(unseen), Parts),
    memberchk(Thing-_, Tried).
